//! Which key does what. The one list for keyboard, menus and help.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};
use probelight_render::gpu::GpuView;

use super::action::{Action, Request};

/// A key, what it does, and what that is called.
#[derive(Clone, Debug)]
pub struct Binding {
    /// The key.
    pub shortcut: KeyboardShortcut,
    /// What it does.
    pub action: Action,
    /// For help.
    pub description: &'static str,
}

/// All keys that do something once when they are pressed.
pub fn bindings() -> Vec<Binding> {
    let ctrl = Modifiers::COMMAND;
    let plain = Modifiers::NONE;
    let binding = |modifiers, key, action, description| Binding {
        shortcut: KeyboardShortcut::new(modifiers, key),
        action,
        description,
    };
    let mut bindings = vec![
        binding(plain, Key::F1, Action::ToggleHelp, "this list"),
        binding(ctrl, Key::O, Action::Request(Request::ChooseFile), "open a scene, a baked file or a setup"),
        binding(ctrl, Key::S, Action::Request(Request::Save), "save the setup"),
        binding(ctrl | Modifiers::SHIFT, Key::S, Action::Request(Request::SaveAs), "save the setup as"),
        binding(ctrl | Modifiers::SHIFT, Key::Z, Action::Redo, "do again"),
        binding(ctrl, Key::Z, Action::Undo, "undo"),
        binding(ctrl, Key::Y, Action::Redo, "do again"),
        binding(ctrl, Key::D, Action::CopySelected, "copy what is selected"),
        binding(plain, Key::Delete, Action::RemoveSelected, "remove what is selected"),
        binding(plain, Key::L, Action::AddLamp, "add a lamp in front of the camera"),
        binding(plain, Key::B, Action::Request(Request::AddBall), "add a ball in front of the camera"),
        binding(plain, Key::F, Action::FocusSelected, "look at what is selected"),
        binding(plain, Key::G, Action::ToggleIndirect, "with and without indirect light"),
        binding(plain, Key::C, Action::NextComparison, "compare: nothing, without indirect light, reference"),
        binding(plain, Key::P, Action::ToggleShading, "diffuse surfaces, or glTF's materials"),
        binding(plain, Key::Space, Action::TogglePlaying, "stop and go on with all that moves by itself"),
        binding(plain, Key::Plus, Action::Brighten(0.5), "brighter"),
        binding(plain, Key::Equals, Action::Brighten(0.5), "brighter"),
        binding(plain, Key::Minus, Action::Brighten(-0.5), "darker"),
        binding(plain, Key::X, Action::ToggleExposure, "automatic exposure, or as it is now"),
        binding(plain, Key::Home, Action::Home, "the first camera"),
        binding(plain, Key::K, Action::KeepCamera, "keep this place as a camera"),
        binding(plain, Key::H, Action::TogglePanels, "all panels, or none"),
        binding(plain, Key::F12, Action::Request(Request::Screenshot), "save the picture"),
        binding(
            plain,
            Key::F11,
            Action::Request(Request::ToggleRecording),
            "save all frames from now on, or stop",
        ),
        binding(plain, Key::Escape, Action::Deselect, "select nothing"),
        binding(ctrl, Key::Q, Action::Request(Request::Quit), "quit"),
    ];
    bindings.extend(DIGITS.into_iter().zip(GpuView::ALL).map(|(digit, view)| Binding {
        shortcut: KeyboardShortcut::new(plain, digit),
        action: Action::Show(view),
        description: view.name(),
    }));
    if cfg!(target_arch = "wasm32") {
        // What pages do not have.
        let of_windows = [Request::SaveAs, Request::Screenshot, Request::ToggleRecording, Request::Quit];
        let of_windows = of_windows.map(Action::Request);
        bindings.retain(|binding| !of_windows.contains(&binding.action));
    }
    bindings
}

/// The digits in the order of [`GpuView::ALL`].
const DIGITS: [Key; GpuView::ALL.len()] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
    Key::Num0,
];

/// What the mouse does, and keys while they are held: for help.
pub const HELD: [(&str, &str); 9] = [
    ("left button", "go around; drag handles and objects; click to pick"),
    ("right button", "look around"),
    ("middle button", "shift the view"),
    ("wheel", "nearer and farther; with the right button held: speed"),
    ("double click", "look at this place from near"),
    ("W A S D", "fly"),
    ("E, Q", "fly up and down"),
    ("Shift", "four times as fast"),
    ("arrows, Page up, Page down", "move what is selected"),
];

/// The key of an action, for menus.
pub fn shortcut_of(action: &Action) -> Option<KeyboardShortcut> {
    bindings().into_iter().find(|binding| binding.action == *action).map(|binding| binding.shortcut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let bindings = bindings();
        for (i, binding) in bindings.iter().enumerate() {
            let same = bindings[..i].iter().find(|other| other.shortcut == binding.shortcut);
            assert!(same.is_none(), "{} and {}", binding.description, same.unwrap().description);
        }
    }

    #[test]
    fn digits_show_all_views_in_order() {
        for (digit, view) in DIGITS.into_iter().zip(GpuView::ALL) {
            let found = bindings().into_iter().find(|b| b.shortcut.logical_key == digit).unwrap();
            assert_eq!(found.action, Action::Show(view));
        }
    }
}
