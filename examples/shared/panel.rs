//! Text over the scene.

use bevy::prelude::*;

/// Text that Tab hides.
#[derive(Component, Clone)]
pub struct Panel;

/// Two empty panels at the left, above and below.
pub fn add_panels(commands: &mut Commands, above: impl Component, below: impl Component) {
    let (top, bottom) = (px(10), px(10));
    let node = Node {
        position_type: PositionType::Absolute,
        left: px(10),
        padding: UiRect::axes(px(10), px(7)),
        ..default()
    };
    let panel = (
        Panel,
        Text::default(),
        TextFont::from_font_size(13.0),
        TextColor(Color::srgb(0.93, 0.93, 0.90)),
        BackgroundColor(Color::srgba(0.02, 0.03, 0.05, 0.75)),
    );
    commands.spawn((
        above,
        panel.clone(),
        Node {
            top,
            ..node.clone()
        },
    ));
    commands.spawn((below, panel, Node { bottom, ..node }));
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
