//! Which key does what. Keys are told by their place, so that W, A, S and D lie together on every keyboard.

use probelight_render::gpu::GpuView;
use winit::keyboard::KeyCode;

/// Explains the keys in the command's help.
pub(super) const HELP: &str = "\
Keys:
  W A S D, E Q            fly; up and down; Shift: four times as fast
  mouse, button held      look around
  arrows, PageUp PageDown move the first light; a directional light turns
  I J K L                 turn the first light, if it is a spot or directional
  O                       let these keys move an object instead, the next one, or the light again
  Space                   let the first light circle
  G                       with and without indirect light
  1 ... 9, 0              full, direct, indirect, irradiance, albedo, normals, lightmap texels,
                          clusters, probes, light samples
  P                       glTF's materials instead of diffuse surfaces
  + -                     exposure
  R                       as at the beginning
  Escape                  quit";

/// What happens while a key is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Motion {
    Forward,
    Back,
    Left,
    Right,
    Up,
    Down,
    Fast,
    LightForward,
    LightBack,
    LightLeft,
    LightRight,
    LightUp,
    LightDown,
    LightTurnsUp,
    LightTurnsDown,
    LightTurnsLeft,
    LightTurnsRight,
}

/// What happens once when a key is pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Show(GpuView),
    ToggleIndirect,
    ToggleShading,
    ToggleCircling,
    ChooseNext,
    Brighter,
    Darker,
    Reset,
    Quit,
}

/// What a key does while it is held.
pub(super) fn motion(key: KeyCode) -> Option<Motion> {
    Some(match key {
        KeyCode::KeyW => Motion::Forward,
        KeyCode::KeyS => Motion::Back,
        KeyCode::KeyA => Motion::Left,
        KeyCode::KeyD => Motion::Right,
        KeyCode::KeyE => Motion::Up,
        KeyCode::KeyQ => Motion::Down,
        KeyCode::ShiftLeft | KeyCode::ShiftRight => Motion::Fast,
        KeyCode::ArrowUp => Motion::LightForward,
        KeyCode::ArrowDown => Motion::LightBack,
        KeyCode::ArrowLeft => Motion::LightLeft,
        KeyCode::ArrowRight => Motion::LightRight,
        KeyCode::PageUp => Motion::LightUp,
        KeyCode::PageDown => Motion::LightDown,
        KeyCode::KeyI => Motion::LightTurnsUp,
        KeyCode::KeyK => Motion::LightTurnsDown,
        KeyCode::KeyJ => Motion::LightTurnsLeft,
        KeyCode::KeyL => Motion::LightTurnsRight,
        _ => return None,
    })
}

/// What a key does when it is pressed.
pub(super) fn action(key: KeyCode) -> Option<Action> {
    Some(match key {
        KeyCode::KeyG => Action::ToggleIndirect,
        KeyCode::KeyP => Action::ToggleShading,
        KeyCode::Space => Action::ToggleCircling,
        KeyCode::KeyO => Action::ChooseNext,
        KeyCode::Equal | KeyCode::NumpadAdd => Action::Brighter,
        KeyCode::Minus | KeyCode::NumpadSubtract => Action::Darker,
        KeyCode::KeyR => Action::Reset,
        KeyCode::Escape => Action::Quit,
        _ => Action::Show(GpuView::ALL[DIGITS.iter().position(|digit| *digit == key)?]),
    })
}

/// The digits in the order of [`GpuView::ALL`].
const DIGITS: [KeyCode; GpuView::ALL.len()] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
    KeyCode::Digit0,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_show_all_views_in_order() {
        for (digit, view) in DIGITS.into_iter().zip(GpuView::ALL) {
            assert_eq!(action(digit), Some(Action::Show(view)));
        }
        assert_eq!(action(KeyCode::KeyW), None);
        assert_eq!(motion(KeyCode::Digit1), None);
    }
}
