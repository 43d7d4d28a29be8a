//! A film: numbered PNG files in a folder, or an MP4 file that the program ffmpeg makes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use glam::UVec2;
use image::RgbaImage;

use crate::picture::{PictureError, write_png};

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The folder can't be made.
    #[error("can't make the folder {}: {reason}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The program isn't there.
    #[error("can't start ffmpeg ({0}), which makes MP4 files: install it, or name a folder for PNG files")]
    NoFfmpeg(std::io::Error),
    /// It gave up.
    #[error("ffmpeg failed: {0}")]
    Ffmpeg(String),
    /// A picture can't be written.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Pictures on their way into a file or a folder.
#[derive(Debug)]
pub struct Film {
    output: Output,
    pictures: u32,
}

#[derive(Debug)]
enum Output {
    Folder(PathBuf),
    Ffmpeg(Child),
}

impl Film {
    /// Begins one at a path: an MP4 file if it ends in `.mp4`, else a folder.
    ///
    /// # Errors
    /// [`FilmError`] if the folder can't be made, or ffmpeg not started.
    pub fn create(path: &Path, fps: u32, size: UVec2) -> Result<Self, FilmError> {
        let is_file = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4"));
        let output = if is_file {
            Output::Ffmpeg(ffmpeg(path, fps, size)?)
        } else {
            std::fs::create_dir_all(path).map_err(|reason| FilmError::Folder { path: path.to_owned(), reason })?;
            Output::Folder(path.to_owned())
        };
        Ok(Self { output, pictures: 0 })
    }

    /// Pictures so far.
    pub fn pictures(&self) -> u32 {
        self.pictures
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// [`FilmError`] if it can't be written.
    pub fn add(&mut self, picture: &RgbaImage) -> Result<(), FilmError> {
        match &mut self.output {
            Output::Folder(folder) => write_png(picture, &folder.join(format!("{:06}.png", self.pictures)))?,
            Output::Ffmpeg(child) => {
                let written = child.stdin.as_mut().map(|pipe| pipe.write_all(picture.as_raw()));
                if let Some(Err(error)) = written {
                    return Err(FilmError::Ffmpeg(last_line(child).unwrap_or(error.to_string())));
                }
            }
        }
        self.pictures += 1;
        Ok(())
    }

    /// Ends it; gives the number of pictures.
    ///
    /// # Errors
    /// [`FilmError::Ffmpeg`] if ffmpeg fails at the end.
    pub fn finish(self) -> Result<u32, FilmError> {
        if let Output::Ffmpeg(mut child) = self.output {
            drop(child.stdin.take());
            let complaint = last_line(&mut child);
            let status = child.wait().map_err(|error| FilmError::Ffmpeg(error.to_string()))?;
            // It says errors alone, and ends well after some of them: where the disk is full, for one.
            if complaint.is_some() || !status.success() {
                return Err(FilmError::Ffmpeg(complaint.unwrap_or(status.to_string())));
            }
        }
        Ok(self.pictures)
    }
}

fn ffmpeg(path: &Path, fps: u32, size: UVec2) -> Result<Child, FilmError> {
    let mut command = Command::new("ffmpeg");
    command.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"]);
    command.args(["-s", &format!("{}x{}", size.x, size.y), "-r", &fps.to_string(), "-i", "-"]);
    // Players want even sizes and this kind of pixels.
    command.args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p"]).arg(path);
    // Ctrl-C is for this program alone: ffmpeg is to end the film.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().map_err(FilmError::NoFfmpeg)
}

fn last_line(child: &mut Child) -> Option<String> {
    let text = std::io::read_to_string(child.stderr.take()?).ok()?;
    text.lines().last().map(str::to_owned)
}
