//! Text over the scene.

use bevy::prelude::*;

/// Text that Tab hides.
#[derive(Component, Clone)]
pub struct Panel;

/// An empty panel at the left; `top` or `bottom` of its node put it at a height.
pub fn panel() -> impl Bundle + Clone {
    (
        Panel,
        Text::default(),
        TextFont::from_font_size(13.0),
        TextColor(Color::srgb(0.93, 0.93, 0.90)),
        BackgroundColor(Color::srgba(0.02, 0.03, 0.05, 0.75)),
    )
}

/// Where a panel is, less its height.
pub fn at_the_left() -> Node {
    Node {
        position_type: PositionType::Absolute,
        left: px(10),
        padding: UiRect::axes(px(10), px(7)),
        ..default()
    }
}

pub fn hide_panels(
    keys: Res<ButtonInput<KeyCode>>,
    mut panels: Query<&mut Visibility, With<Panel>>,
) {
    if keys.just_pressed(KeyCode::Tab) {
        for mut visibility in &mut panels {
            visibility.toggle_inherited_hidden();
        }
    }
}
