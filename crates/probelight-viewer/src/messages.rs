//! What the window tells: for a while, or until it is read.

use std::time::Duration;

use eframe::egui::{Align2, Area, Color32, Context, Frame, Id, RichText, vec2};
use web_time::Instant;

/// How long a note stays.
const NOTE_TIME: Duration = Duration::from_secs(6);

/// One message.
#[derive(Clone, Debug)]
struct Message {
    text: String,
    /// Errors stay until they are read.
    is_error: bool,
    since: Instant,
}

/// What is told at present.
#[derive(Clone, Debug, Default)]
pub struct Messages(Vec<Message>);

impl Messages {
    /// Something good to know.
    pub fn note(&mut self, text: impl Into<String>) {
        self.add(text.into(), false);
    }

    /// Something that went wrong. Said once, however often it happens.
    pub fn error(&mut self, text: impl Into<String>) {
        self.add(text.into(), true);
    }

    fn add(&mut self, text: String, is_error: bool) {
        self.0.retain(|message| message.text != text);
        self.0.push(Message { text, is_error, since: Instant::now() });
    }

    /// All of them, the oldest first.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|message| message.text.as_str())
    }

    /// Shows them at the bottom of the picture.
    pub fn show(&mut self, context: &Context) {
        self.0.retain(|message| message.is_error || message.since.elapsed() < NOTE_TIME);
        if self.0.is_empty() {
            return;
        }
        let mut read = None;
        let area = Area::new(Id::new("messages")).anchor(Align2::CENTER_BOTTOM, vec2(0.0, -190.0));
        area.show(context, |ui| {
            for (number, message) in self.0.iter().enumerate() {
                Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width(560.0);
                    ui.horizontal(|ui| {
                        let color = if message.is_error {
                            Color32::from_rgb(255, 110, 90)
                        } else {
                            Color32::LIGHT_GRAY
                        };
                        ui.label(RichText::new(&message.text).color(color));
                        if message.is_error && ui.small_button("✖").clicked() {
                            read = Some(number);
                        }
                    });
                });
            }
        });
        if let Some(number) = read {
            self.0.remove(number);
        }
        context.request_repaint_after(Duration::from_millis(500));
    }
}
