//! Pictures of objects and lights that move, one for each frame.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;
use probelight_render::Exposure;
use probelight_runtime::ObjectId;
use probelight_scene::{Camera, Lighting, Setup};

use crate::console::Console;
use crate::movers::Movers;
use crate::output::{self, PictureFormat};
use crate::studio::{PictureOptions, Studio};
use crate::{input, interrupt};

/// What an animation is made of.
pub(crate) struct Frames<'a> {
    pub(crate) seconds: f32,
    pub(crate) fps: u32,
    pub(crate) folder: &'a Path,
    /// Whose lights move.
    pub(crate) setup: &'a Setup,
    /// That of the first frame is kept for all; `None` for pictures of colours.
    pub(crate) exposure: Option<Exposure>,
}

/// The picture of a frame.
pub(crate) fn frame_file(folder: &Path, frame: u32) -> PathBuf {
    folder.join(format!("frame_{frame:04}.png"))
}

impl Frames<'_> {
    /// Draws all frames of a lit scene, each with light that has come to rest, and a video of them if it can.
    pub(crate) fn write(
        &self,
        studio: &mut Studio,
        movers: &Movers,
        objects: &[ObjectId],
        camera: &Camera,
        options: &PictureOptions,
        console: &Console,
    ) -> anyhow::Result<()> {
        let frames = ((self.seconds * self.fps as f32).round() as u32).max(1);
        let mut exposure = self.exposure;
        for frame in 0..frames {
            interrupt::check()?;
            let time = frame as f32 / self.fps as f32;
            let lighting = self.setup.lighting_at(time);
            // The scene is lit already with objects where they begin and lights where they stand.
            if frame > 0 || lighting != self.setup.lighting {
                movers.place(objects, studio.objects_mut(), time)?;
                studio.set_lighting(lighting)?;
                studio.settle(console)?;
            }
            let image = studio.picture(camera, options, console)?;
            let file = frame_file(self.folder, frame);
            if let Some(ev) = output::write_picture(&image, &file, PictureFormat::Png, exposure)? {
                exposure = Some(Exposure::Ev(ev));
            }
            console.clear_progress();
            console.note(format!("frame {} of {frames}: {}", frame + 1, file.display()));
        }
        self.write_video(console)
    }

    fn write_video(&self, console: &Console) -> anyhow::Result<()> {
        let video = self.folder.join("video.mp4");
        let made = Command::new("ffmpeg")
            .args(["-y", "-loglevel", "error", "-framerate", &self.fps.to_string(), "-i"])
            .arg(self.folder.join("frame_%04d.png"))
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
            .arg(&video)
            .status();
        match made {
            Ok(status) if status.success() => console.note(format!("wrote {}", video.display())),
            Ok(status) => console.warn(format!("ffmpeg made no video of the frames ({status})")),
            Err(_) => console.note("no video: ffmpeg is not there"),
        }
        Ok(())
    }
}

impl Studio {
    fn set_lighting(&mut self, lighting: Lighting) -> anyhow::Result<()> {
        match self {
            Self::Cpu(runtime) => runtime.set_lighting(lighting).context("the setup's lights")?,
            Self::Gpu(studio) => studio.runtime.set_lighting(lighting).context("the setup's lights")?,
        }
        Ok(())
    }

    /// Lets light bounce until nothing changes any more.
    fn settle(&mut self, console: &Console) -> anyhow::Result<usize> {
        match self {
            Self::Cpu(runtime) => Ok(input::settle(runtime, console)),
            Self::Gpu(studio) => {
                input::settle_on_gpu(&mut studio.runtime, console).context("a frame's light")
            }
        }
    }
}
