//! The camera of a picture: one of the scene, one given by position and target, or one that shows
//! the whole scene.

use std::str::FromStr;

use kinetree_render::default_camera;
use kinetree_world::{Camera, CameraSource, Frame, World};

use crate::failure::Failure;

/// A camera as given on the command line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum CameraChoice {
    /// A camera of the scene, by name.
    Named(String),
    /// A camera given by position, target and field of view.
    Placed(Camera),
}

/// The vertical field of view when none is given, degrees.
const DEFAULT_FOV: f32 = 50.0;

const FORMAT: &str =
    "write a camera as px,py,pz:tx,ty,tz or px,py,pz:tx,ty,tz:degrees: position, target and field of view";

impl FromStr for CameraChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let is_position =
            text.contains(':') && text.contains(',') && text.chars().all(|c| "0123456789+-.,:eE ".contains(c));
        if !is_position {
            return Ok(Self::Named(text.to_owned()));
        }
        let parts: Vec<&str> = text.split(':').collect();
        let (&[eye, target], view) = parts.split_first_chunk::<2>().ok_or(FORMAT)?;
        let (eye, target) = (point(eye)?, point(target)?);
        let degrees = match view {
            [] => DEFAULT_FOV,
            [degrees] => number(degrees)?,
            _ => return Err(FORMAT.into()),
        };
        if eye.iter().zip(&target).all(|(a, b)| a.to_bits() == b.to_bits() || a == b) {
            return Err("position and target are the same".into());
        }
        if !(0.1..=170.0).contains(&degrees) {
            return Err("the field of view goes from 0.1 to 170 degrees".into());
        }
        Ok(Self::Placed(Camera::look_at(eye, target, degrees.to_radians())))
    }
}

fn point(text: &str) -> Result<[f32; 3], String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    numbers.try_into().map_err(|_| FORMAT.into())
}

fn number(text: &str) -> Result<f32, String> {
    text.trim().parse::<f32>().ok().filter(|number| number.is_finite()).ok_or_else(|| FORMAT.into())
}

/// The camera of a sequence of frames.
pub(crate) enum PictureCamera {
    /// A camera of the scene, which moves with its node.
    Source(CameraSource),
    /// A camera that does not move.
    Fixed(Camera),
    /// A camera that shows the whole scene of the first frame, and does not move afterwards.
    ShowsAll,
}

impl PictureCamera {
    /// Finds the camera that was requested among those of the scene.
    pub(crate) fn choose(
        choice: Option<&CameraChoice>,
        cameras: &[CameraSource],
        scene: &str,
    ) -> Result<Self, Failure> {
        match choice {
            Some(CameraChoice::Placed(camera)) => Ok(Self::Fixed(*camera)),
            Some(CameraChoice::Named(name)) => match cameras.iter().find(|source| source.name == *name) {
                Some(source) => Ok(Self::Source(source.clone())),
                None => Err(Failure::arguments(format!("{scene}: there is no camera {name:?}; {}", list(cameras)))),
            },
            None => Ok(cameras.first().map_or(Self::ShowsAll, |first| Self::Source(first.clone()))),
        }
    }

    /// The camera in the world's latest frame. `aspect` is width over height.
    pub(crate) fn camera(&mut self, world: &World, frame: &Frame, aspect: f32) -> Result<Camera, Failure> {
        match self {
            Self::Source(source) => {
                world.camera(source).map_err(|error| Failure::work(format!("camera {:?}: {error}", source.name)))
            }
            Self::Fixed(camera) => Ok(*camera),
            Self::ShowsAll => {
                let camera = default_camera(frame, aspect);
                *self = Self::Fixed(camera);
                Ok(camera)
            }
        }
    }
}

/// A clause that lists the cameras.
fn list(cameras: &[CameraSource]) -> String {
    /// The most names that are listed.
    const MOST_LISTED: usize = 30;
    let named: Vec<String> =
        cameras.iter().filter(|source| !source.name.is_empty()).map(|source| format!("{:?}", source.name)).collect();
    let unnamed = cameras.len() - named.len();
    let more = named.len().saturating_sub(MOST_LISTED);
    let mut text = match (named.len(), unnamed) {
        (0, 0) => return "it has none".into(),
        (0, _) => return format!("its {unnamed} cameras have no names"),
        _ => format!("there are {}", named[..named.len() - more].join(", ")),
    };
    if more + unnamed > 0 {
        text += &format!(" and {} more", more + unnamed);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_and_a_target_make_a_camera() {
        let Ok(CameraChoice::Placed(camera)) = "1,-2.5,3e1:0,0,0:40".parse() else {
            panic!("this is a position and a target")
        };
        assert_eq!(camera.position(), [1.0, -2.5, 30.0]);
        assert!((camera.fov_y - 40_f32.to_radians()).abs() < 1e-6);
        assert!(matches!("1,2,3:0,0,0".parse(), Ok(CameraChoice::Placed(_))));
    }

    #[test]
    fn what_is_no_position_is_a_name_and_what_is_nearly_one_is_refused() {
        for name in ["track", "cam:1", "a,b,c:d,e,f", "2", ""] {
            assert_eq!(name.parse(), Ok(CameraChoice::Named(name.into())));
        }
        for wrong in ["1,2:3,4,5", "1,2,3:4,5,6:", "1,2,3:4,5,6:0", "1,2,3:4,5,6:7:8", "1,2,3:1,2,3", "1,2,3:1e99,0,0"]
        {
            assert!(wrong.parse::<CameraChoice>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_those_there_are() {
        let camera = Camera::look_at([0.0; 3], [1.0; 3], 1.0);
        let source = |name: &str| CameraSource { name: name.into(), node: None, camera };
        let complaint = |cameras: &[CameraSource]| {
            let choice = CameraChoice::Named("south".into());
            let Err(failure) = PictureCamera::choose(Some(&choice), cameras, "a.glb") else {
                panic!("there is no south")
            };
            failure.to_string()
        };
        assert_eq!(complaint(&[]), "a.glb: there is no camera \"south\"; it has none");
        assert!(complaint(&[source("")]).ends_with("its 1 cameras have no names"));
        assert!(
            complaint(&[source("north"), source("east"), source("")])
                .ends_with("there are \"north\", \"east\" and 1 more")
        );
    }
}
