//! Recorded pictures: numbered PNG files in a folder, or an MP4 file that the program ffmpeg
//! encodes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use glam::UVec2;
use image::RgbaImage;

use crate::picture::{PictureError, write_png};

/// The error of recording pictures.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// The folder can't be created.
    #[error("can't create the folder {}: {reason}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's error.
        reason: std::io::Error,
    },
    /// The program ffmpeg can't be started.
    #[error(
        "can't start ffmpeg ({0}), which encodes MP4 files: install it, or give a folder for PNG \
         files"
    )]
    NoFfmpeg(std::io::Error),
    /// The program ffmpeg failed.
    #[error("ffmpeg failed: {0}")]
    Ffmpeg(String),
    /// A picture can't be written.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Writes a sequence of pictures to a folder or a video file.
#[derive(Debug)]
pub struct VideoWriter {
    output: Output,
    pictures: u32,
}

#[derive(Debug)]
enum Output {
    Folder(PathBuf),
    Ffmpeg(Child),
}

impl VideoWriter {
    /// Starts writing to a path: an MP4 file if it ends in `.mp4`, else a folder.
    ///
    /// # Errors
    /// [`VideoError`] if the folder can't be created, or ffmpeg can't be started.
    pub fn create(path: &Path, fps: u32, size: UVec2) -> Result<Self, VideoError> {
        let is_file =
            path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4"));
        let output = if is_file {
            Output::Ffmpeg(ffmpeg(path, fps, size)?)
        } else {
            std::fs::create_dir_all(path)
                .map_err(|reason| VideoError::Folder { path: path.to_owned(), reason })?;
            Output::Folder(path.to_owned())
        };
        Ok(Self { output, pictures: 0 })
    }

    /// The number of pictures so far.
    pub fn pictures(&self) -> u32 {
        self.pictures
    }

    /// Appends a picture.
    ///
    /// # Errors
    /// [`VideoError`] if it can't be written.
    pub fn add(&mut self, picture: &RgbaImage) -> Result<(), VideoError> {
        match &mut self.output {
            Output::Folder(folder) => {
                write_png(picture, &folder.join(format!("{:06}.png", self.pictures)))?
            }
            Output::Ffmpeg(child) => {
                let written = child.stdin.as_mut().map(|pipe| pipe.write_all(picture.as_raw()));
                if let Some(Err(error)) = written {
                    return Err(VideoError::Ffmpeg(last_line(child).unwrap_or(error.to_string())));
                }
            }
        }
        self.pictures += 1;
        Ok(())
    }

    /// Finishes writing, and returns the number of pictures.
    ///
    /// # Errors
    /// [`VideoError::Ffmpeg`] if ffmpeg fails at the end.
    pub fn finish(self) -> Result<u32, VideoError> {
        if let Output::Ffmpeg(mut child) = self.output {
            drop(child.stdin.take());
            let message = last_line(&mut child);
            let status = child.wait().map_err(|error| VideoError::Ffmpeg(error.to_string()))?;
            // ffmpeg prints only errors here, and exits with success after some of them, for
            // example on a full disk.
            if message.is_some() || !status.success() {
                return Err(VideoError::Ffmpeg(message.unwrap_or(status.to_string())));
            }
        }
        Ok(self.pictures)
    }
}

fn ffmpeg(path: &Path, fps: u32, size: UVec2) -> Result<Child, VideoError> {
    let mut command = Command::new("ffmpeg");
    command.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"]);
    command.args(["-s", &format!("{}x{}", size.x, size.y), "-r", &fps.to_string(), "-i", "-"]);
    // Many players support only even sizes and this pixel format. The same pictures give the same
    // bytes: no date, no version, and no dependence on the number of processors.
    command.args([
        "-threads",
        "2",
        "-map_metadata",
        "-1",
        "-fflags",
        "+bitexact",
        "-flags:v",
        "+bitexact",
    ]);
    command.args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p"]).arg(path);
    // In a process group of its own, ffmpeg doesn't receive Ctrl-C and can finish the file.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().map_err(VideoError::NoFfmpeg)
}

fn last_line(child: &mut Child) -> Option<String> {
    let text = std::io::read_to_string(child.stderr.take()?).ok()?;
    text.lines().last().map(str::to_owned)
}
