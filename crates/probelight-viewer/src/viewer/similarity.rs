//! Holds how similar pictures are to those without levels of detail: whenever nothing moves, it looks how near levels may
//! begin.
//!
//! The picture that one sees stands still meanwhile; those that are compared are drawn out of sight.

use probelight_eval::{EvalError, ImageView, ssim};
use probelight_math::color::linear_from_srgb8;
use probelight_math::glam::Vec3;
use probelight_render::DisplayImage;
use probelight_runtime::gpu::GpuError;
use probelight_runtime::{LodSettings, SimilaritySearch};

use super::Viewer;
use crate::picture::screen::Screen;
use crate::scene::pending::{Pending, take_ready};
use crate::state::Document;
use crate::state::view_state::{Compare, ViewState};

/// Frames in which the light of other levels settles.
const FRAMES_PER_PICTURE: u32 = 12;

/// Where levels begin so that pictures are similar enough.
#[derive(Default)]
pub(super) struct HeldSimilarity {
    /// Factor on their distances, once one was found.
    pub(super) scale: Option<f32>,
    /// What it was found for.
    seen: Option<(Document, ViewState)>,
    search: Option<Search>,
}

/// A search that goes on.
struct Search {
    by: SimilaritySearch,
    screen: Screen,
    frames: u32,
    answer: Option<Pending<Result<DisplayImage, GpuError>>>,
    /// The picture without levels of detail, once it was drawn.
    exact: Option<DisplayImage>,
}

impl HeldSimilarity {
    pub(super) fn is_searching(&self) -> bool {
        self.search.is_some()
    }

    /// Whether a search has ended for what is shown now.
    fn knows(&self, document: &Document, view: &ViewState) -> bool {
        self.seen.as_ref().is_some_and(|(d, v)| d == document && v == view)
    }

    /// Ends the search for what is shown now.
    fn end(&mut self, document: &Document, view: &ViewState) {
        self.seen = Some((document.clone(), view.clone()));
        self.search = None;
    }
}

impl Search {
    /// The levels of the picture that is drawn next.
    fn levels(&self, wanted: &LodSettings) -> LodSettings {
        match (&self.exact, self.by.scale()) {
            (Some(_), Some(scale)) => wanted.clone().with_distances_scaled(scale),
            _ => LodSettings::default(),
        }
    }

    /// Takes a picture.
    fn note(&mut self, picture: DisplayImage) -> Result<(), EvalError> {
        match &self.exact {
            Some(exact) => _ = self.by.note(similarity(&picture, exact)?),
            None => self.exact = Some(picture),
        }
        self.frames = 0;
        Ok(())
    }
}

fn similarity(a: &DisplayImage, b: &DisplayImage) -> Result<f64, EvalError> {
    let linear = |image: &DisplayImage| -> Vec<Vec3> {
        image.pixels.iter().map(|pixel| linear_from_srgb8(*pixel)).collect()
    };
    let (width, height) = (a.width as usize, a.height as usize);
    ssim(&ImageView::new(width, height, &linear(a))?, &ImageView::new(width, height, &linear(b))?)
}

impl Viewer {
    /// Looks for the levels that hold the similarity of the view, a frame's worth.
    pub(super) fn hold_similarity(&mut self) -> Result<(), GpuError> {
        let (document, view) = (&self.state.document, &self.state.view);
        let (Some(least), Some(_)) = (view.hold_similarity, &self.live) else {
            self.held = HeldSimilarity::default();
            return Ok(());
        };
        if self.is_changing() {
            self.held.search = None;
            return Ok(());
        }
        if self.held.knows(document, view) {
            return Ok(());
        }
        if self.held.search.is_none() {
            let mut screen = Screen::new(&self.gpu)?;
            let (width, height) = self.screen.size();
            screen.resize(width, height)?;
            let by = SimilaritySearch::new(f64::from(least));
            self.held.search = Some(Search { by, screen, frames: 0, answer: None, exact: None });
        }
        self.go_on_searching()
    }

    fn go_on_searching(&mut self) -> Result<(), GpuError> {
        let Self { live: Some(live), held, state, .. } = self else { return Ok(()) };
        let Some(search) = &mut held.search else { return Ok(()) };
        if let Some(answer) = take_ready(&mut search.answer) {
            if let Err(error) = search.note(answer?) {
                self.messages.error(format!("the similarity cannot be held: {error}"));
                held.end(&state.document, &state.view);
                return Ok(());
            }
        } else if search.answer.is_some() {
            return Ok(());
        }
        if search.by.scale().is_none() {
            held.scale = Some(search.by.found());
            held.end(&state.document, &state.view);
            self.settle_again();
            return Ok(());
        }
        let levels = search.levels(&state.view.lod);
        if *live.runtime.lod() != levels {
            live.runtime.set_lod(levels)?;
        }
        if search.frames < FRAMES_PER_PICTURE {
            search.frames += 1;
            live.light(&state.view.camera, state.view.options, false, None);
            return Ok(());
        }
        let plain = ViewState { compare: Compare::Nothing, marks: false, ..state.view.clone() };
        search.screen.draw(live, &plain, state.shown_ev, 0.0, None)?;
        search.answer = Some(Pending::new(search.screen.read_async()));
        Ok(())
    }
}
