//! What the import needs to know about the camera and the belt.

use super::class_names::ClassNames;
use super::formats::Format;
use crate::error::{Error, Result, known_names, shown};
use crate::setters::setters;
use std::str::FromStr;

/// Values outside this range are typing mistakes, and their squares may overflow.
const SENSIBLE: std::ops::RangeInclusive<f64> = 1e-9..=1e6;

/// The image axis along which the belt travels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ImageAxis {
    /// Image x: items cross the image horizontally.
    X,
    /// Image y: items cross the image vertically.
    Y,
}

impl Boxes {
    /// The name of the option's value.
    fn name(self) -> &'static str {
        match self {
            Self::Sizes => "sizes",
            Self::Corners => "corners",
            Self::Centres => "centres",
        }
    }
}

impl FromStr for Boxes {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let all = [Self::Sizes, Self::Corners, Self::Centres];
        all.into_iter()
            .find(|boxes| boxes.name() == text)
            .ok_or_else(|| {
                Error::usage(
                    "'boxes'",
                    format!("`{}` is not a meaning of the figures of a box", shown(text)),
                    known_names(text, &all.map(Self::name)),
                )
            })
    }
}

impl FromStr for ImageAxis {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.trim() {
            "x" | "X" => Ok(Self::X),
            "y" | "Y" => Ok(Self::Y),
            _ => Err(Error::usage(
                "'axis'",
                format!("`{}` is not an image axis", shown(text)),
                "give x or y, the image axis along which the belt travels",
            )),
        }
    }
}

/// The meaning of the four numbers of a box. Some file formats define it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Boxes {
    /// Left, top, width, height.
    #[default]
    Sizes,
    /// Left, top, right, bottom.
    Corners,
    /// Centre along x and y, width, height.
    Centres,
}

/// The conversion of pixels and frames to metres and seconds, and the tolerances.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ImportOptions {
    /// Frames per second of the recording [1/s].
    pub fps: f64,
    /// Size of a pixel on the belt [m/px].
    pub scale_m_per_px: f64,
    /// The image axis along which the belt travels.
    pub axis: ImageAxis,
    /// Whether items travel towards smaller pixel values.
    pub reverse: bool,
    /// Angle of the travel from that axis, positive towards larger pixel values of the other axis
    /// [degrees].
    pub angle_deg: f64,
    /// Belt speed during the recording [m/s].
    pub belt_speed: f64,
    /// The file format; `None` to detect it from the content.
    pub format: Option<Format>,
    /// The meaning of the four numbers of a box; `None` for sizes, or what the file format defines.
    pub boxes: Option<Boxes>,
    /// Width and height of the image [px], for boxes given as fractions of them.
    pub image_size: Option<(f64, f64)>,
    /// Whether to create a pattern even if the tracks contradict the options so much that it must
    /// be wrong.
    pub accept_mismatch: bool,
    /// Pixel of the belt's centre line on the axis across the travel [px]; `None` for the middle
    /// between the outermost items.
    pub centre_px: Option<f64>,
    /// Minimum number of frames; objects seen in fewer are dropped.
    pub min_frames: usize,
    /// A track that jumps further than this between consecutive boxes, against the belt's motion,
    /// is split [m].
    pub split_distance_m: f64,
    /// Consecutive tracks whose x0 and y agree this closely are one object [m].
    pub merge_distance_m: f64,
    /// Names of the class ids; `None` to keep the classes as they are in the file.
    pub class_names: Option<ClassNames>,
}

setters!(ImportOptions {
    /// With travel towards smaller pixel values, or towards larger ones.
    fn with_reverse(reverse: bool);
    /// With travel at this angle from the axis [degrees].
    fn with_angle_deg(angle_deg: f64);
    /// With this file format, or the one detected.
    fn with_format(format: impl Into<Option<Format>>);
    /// With this meaning of the four numbers of a box, or the usual one of the format.
    fn with_boxes(boxes: impl Into<Option<Boxes>>);
    /// With this width and height of the image [px].
    fn with_image_size(image_size: impl Into<Option<(f64, f64)>>);
    /// With a pattern even if the tracks contradict the options.
    fn with_accept_mismatch(accept_mismatch: bool);
    /// With this pixel of the belt's centre line [px], or the middle of the items.
    fn with_centre_px(centre_px: impl Into<Option<f64>>);
    /// With this minimum number of frames of an object.
    fn with_min_frames(min_frames: usize);
    /// With tracks split where they jump further than this [m].
    fn with_split_distance_m(split_distance_m: f64);
    /// With tracks joined that agree this closely [m].
    fn with_merge_distance_m(merge_distance_m: f64);
    /// With these names of the class ids, or the classes of the file.
    fn with_class_names(class_names: impl Into<Option<ClassNames>>);
});

impl ImportOptions {
    /// Options with the four values that no file contains, [1/s], [m/px] and [m/s], and defaults
    /// for the rest: travel towards larger pixel values, centre line from the items, at least 2
    /// frames, split at 0.1 m, merge at 0.02 m.
    pub fn new(fps: f64, scale_m_per_px: f64, axis: ImageAxis, belt_speed: f64) -> Self {
        Self {
            fps,
            scale_m_per_px,
            axis,
            reverse: false,
            angle_deg: 0.0,
            belt_speed,
            format: None,
            boxes: None,
            image_size: None,
            accept_mismatch: false,
            centre_px: None,
            min_frames: 2,
            split_distance_m: 0.1,
            merge_distance_m: 0.02,
            class_names: None,
        }
    }

    /// Rejects values that no camera or belt has; the error names the setting.
    pub(super) fn check(&self) -> Result<()> {
        let figures = [
            (
                "'fps'",
                self.fps,
                "frame rate",
                "the camera's frames per second, for example 25",
            ),
            (
                "'scale_m_per_px'",
                self.scale_m_per_px,
                "scale",
                "metres on the belt per pixel, for example 0.001",
            ),
            (
                "'belt_speed'",
                self.belt_speed,
                "speed",
                "the belt's speed in m/s, for example 0.05",
            ),
            (
                "'split_distance_m'",
                self.split_distance_m,
                "distance",
                "metres, for example 0.1",
            ),
            (
                "'merge_distance_m'",
                self.merge_distance_m,
                "distance",
                "metres, for example 0.02",
            ),
        ];
        for (setting, value, what, cure) in figures {
            // NaN is in no range.
            if !SENSIBLE.contains(&value) {
                let (least, most) = (SENSIBLE.start(), SENSIBLE.end());
                return Err(Error::usage(
                    setting,
                    format!("{value:?} is not a valid {what}: expected {least:?} to {most:?}"),
                    format!("give {cure}"),
                ));
            }
        }
        if !(-89.0..=89.0).contains(&self.angle_deg) {
            return Err(Error::usage(
                "'angle_deg'",
                format!("{:?} is not a valid angle from 'axis'", self.angle_deg),
                "give degrees from -89 to 89",
            ));
        }
        if let Some((width, height)) = self.image_size
            && !(SENSIBLE.contains(&width) && SENSIBLE.contains(&height))
        {
            return Err(Error::usage(
                "'image_size'",
                format!("{width:?}x{height:?} is not a valid image size"),
                "give the width and height in pixels, for example 1280x720",
            ));
        }
        if self.min_frames == 0 {
            return Err(Error::usage(
                "'min_frames'",
                "0 is not a valid number of frames",
                "give 1 to keep every object, or 2 to drop those seen only once",
            ));
        }
        match self.centre_px {
            Some(pixel) if !(pixel.is_finite() && pixel.abs() <= *SENSIBLE.end()) => {
                Err(Error::usage(
                    "'centre_px'",
                    format!("{pixel:?} is not a valid pixel"),
                    "give the pixel of the belt's centre line on the axis across the travel, \
                     or omit the flag",
                ))
            }
            _ => Ok(()),
        }
    }

    /// The kind of boxes in a file format that defines it; `source` names the format.
    ///
    /// # Errors
    /// If a different kind was given.
    pub(super) fn boxes_of(&self, own: Boxes, source: &str) -> Result<Boxes> {
        match self.boxes {
            Some(given) if given != own => Err(Error::usage(
                "'boxes'",
                format!(
                    "in {source} the boxes are {}, not {}",
                    own.name(),
                    given.name()
                ),
                "omit 'boxes'",
            )),
            _ => Ok(own),
        }
    }

    /// Converts image coordinates to pixels along and across the travel. The first grows in the
    /// direction of travel, the second in the direction of the image axis.
    pub(super) fn turned(&self, image_x: f64, image_y: f64) -> (f64, f64) {
        let (along, across) = match self.axis {
            ImageAxis::X => (image_x, image_y),
            ImageAxis::Y => (image_y, image_x),
        };
        let along = if self.reverse { -along } else { along };
        if self.angle_deg == 0.0 {
            return (along, across);
        }
        let (sine, cosine) = self.angle_deg.to_radians().sin_cos();
        (
            cosine * along + sine * across,
            cosine * across - sine * along,
        )
    }

    /// +1 if the pixel values across the travel grow to its left, which is belt +y, and -1 if they
    /// grow to its right (see the table at the top of the module).
    pub(super) fn left(&self) -> f64 {
        match (self.axis, self.reverse) {
            (ImageAxis::X, false) | (ImageAxis::Y, true) => -1.0,
            (ImageAxis::X, true) | (ImageAxis::Y, false) => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_is_checked_and_named() {
        type Set = fn(&mut ImportOptions, f64);
        let good = ImportOptions::new(25.0, 0.001, ImageAxis::X, 0.05);
        assert!(good.check().is_ok());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
            let set: [(&str, Set); 5] = [
                ("'fps'", |o, v| o.fps = v),
                ("'scale_m_per_px'", |o, v| o.scale_m_per_px = v),
                ("'belt_speed'", |o, v| o.belt_speed = v),
                ("'split_distance_m'", |o, v| o.split_distance_m = v),
                ("'merge_distance_m'", |o, v| o.merge_distance_m = v),
            ];
            for (flag, set) in set {
                let mut options = good.clone();
                set(&mut options, bad);
                let message = options.check().unwrap_err().to_string();
                assert!(message.starts_with(flag), "{message}");
                assert!(message.contains(&format!("{bad:?}")), "{message}");
            }
        }
        let mut options = good.clone();
        options.min_frames = 0;
        let message = options.check().unwrap_err().to_string();
        assert!(message.starts_with("'min_frames'"), "{message}");
        for bad in [f64::NAN, f64::NEG_INFINITY, 1e12] {
            let mut options = good.clone();
            options.centre_px = Some(bad);
            let message = options.check().unwrap_err().to_string();
            assert!(message.starts_with("'centre_px'"), "{message}");
        }
    }

    #[test]
    fn axes_are_read_from_text() {
        assert_eq!("x".parse::<ImageAxis>().unwrap(), ImageAxis::X);
        assert_eq!("Y".parse::<ImageAxis>().unwrap(), ImageAxis::Y);
        let mut options = ImportOptions::new(25.0, 0.001, ImageAxis::X, 0.05);
        options.angle_deg = 30.0;
        let half = 0.75f64.sqrt();
        let (along, across) = options.turned(half, 0.5);
        assert!((along - 1.0).abs() < 1e-15 && across.abs() < 1e-15);
        options.angle_deg = 90.0;
        assert!(
            options
                .check()
                .unwrap_err()
                .to_string()
                .starts_with("'angle_deg'")
        );
        let message = "z".parse::<ImageAxis>().unwrap_err().to_string();
        assert!(
            message.contains("'axis'") && message.contains("`z`"),
            "{message}"
        );
    }

    #[test]
    fn the_belt_frame_is_right_handed() {
        // With z towards the camera, x cross y must be +z. On the screen (y down) this means that
        // turning the travel a quarter counterclockwise gives belt y.
        for (axis, reverse, travel) in [
            (ImageAxis::X, false, (1.0, 0.0)),
            (ImageAxis::X, true, (-1.0, 0.0)),
            (ImageAxis::Y, false, (0.0, 1.0)),
            (ImageAxis::Y, true, (0.0, -1.0)),
        ] {
            let mut options = ImportOptions::new(25.0, 0.001, axis, 0.05);
            options.reverse = reverse;
            let (along, _) = options.turned(travel.0, travel.1);
            assert_eq!(along, 1.0, "{axis:?} {reverse}: the travel is belt x");
            let left: (f64, f64) = (travel.1, -travel.0);
            let (along, across) = options.turned(left.0, left.1);
            assert_eq!(along, 0.0);
            assert_eq!(across * options.left(), 1.0, "{axis:?} {reverse}");
        }
    }
}
