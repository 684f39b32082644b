//! `compare A.png B.png` prints in how many pixels the pictures differ, `compare A.png` how many
//! colors there are.

use std::{collections::BTreeSet, env, error::Error, path::Path};

use image::RgbImage;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = env::args_os().skip(1).collect();
    match arguments.as_slice() {
        [one] => {
            let one = read(one.as_ref())?;
            let colors: BTreeSet<_> = one.pixels().map(|pixel| pixel.0).collect();
            println!("{}", colors.len());
        }
        [one, other] => {
            let (one, other) = (read(one.as_ref())?, read(other.as_ref())?);
            if one.dimensions() != other.dimensions() {
                return Err("the pictures are not of one size".into());
            }
            let differ = one.pixels().zip(other.pixels()).filter(|(a, b)| a != b);
            println!("{}", differ.count());
        }
        _ => return Err("one picture or two".into()),
    }
    Ok(())
}

fn read(path: &Path) -> Result<RgbImage, Box<dyn Error>> {
    Ok(image::open(path)?.into_rgb8())
}
