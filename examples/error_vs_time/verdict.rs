//! Ours against the second camera, scene by scene: what the report is for.

use bevy_planar_mirror::MirrorClip;

use crate::{row::Row, shared::table::aligned, techniques::Kind};

/// A table of error and time of the automatic mirror and of the full-size second camera.
pub fn verdict(rows: &[Row]) -> String {
    const RIVAL: Kind = Kind::SecondCamera {
        divisor: 1,
        clip: true,
    };
    let head = [
        "scene",
        "MSAA",
        "mirror %",
        "ours RMSE",
        "theirs",
        "bound",
        "ours ms",
        "theirs",
        "bound",
        "ahead",
    ];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    for ours in rows {
        if ours.technique.kind != Kind::Ours(MirrorClip::Auto) {
            continue;
        }
        let find = |kind| {
            rows.iter()
                .find(|row| {
                    row.scene == ours.scene && row.technique.is(kind, ours.technique.samples)
                })
                .and_then(Row::place)
        };
        let places = [ours.place(), find(RIVAL), find(Kind::Bound)];
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        let mut line = vec![
            ours.scene.to_owned(),
            ours.technique.samples.to_string(),
            format!("{:.0}", ours.share * 100.0),
        ];
        line.extend(places.map(|place| number(place.map(|(_, error)| error))));
        line.extend(places.map(|place| number(place.map(|(time, _)| time))));
        line.push(ahead(places[0], places[1]));
        lines.push(line);
    }
    aligned(&lines)
}

/// Who is ahead in what. Differences below a hundredth are none.
fn ahead(ours: Option<(f64, f64)>, theirs: Option<(f64, f64)>) -> String {
    let (Some((our_time, our_error)), Some((their_time, their_error))) = (ours, theirs) else {
        return "-".to_owned();
    };
    let one = |ours: f64, theirs: f64| {
        if (ours - theirs).abs() <= 0.01 * theirs.max(ours) {
            "even"
        } else if ours < theirs {
            "ours"
        } else {
            "theirs"
        }
    };
    let (error, time) = (one(our_error, their_error), one(our_time, their_time));
    format!("error {error}, time {time}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_number_is_ahead() {
        let ahead = |a, b| ahead(Some(a), Some(b));
        assert_eq!(ahead((1.0, 5.0), (2.0, 1.0)), "error theirs, time ours");
        assert_eq!(ahead((2.0, 1.0), (1.0, 1.005)), "error even, time theirs");
        assert_eq!(super::ahead(None, Some((1.0, 1.0))), "-");
    }
}
