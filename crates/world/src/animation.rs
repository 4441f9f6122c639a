//! Animation: bringing a scene to a time.

use kinetree::{EditError, Scene};

/// Moves a scene.
pub trait Animation: Send {
    /// Edits the scene so that it shows a time, in seconds. Called with times in any order.
    ///
    /// # Errors
    /// An edit that the scene refused; earlier edits of the call remain.
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError>;

    /// Seconds after which the animation repeats; 0 when nothing moves.
    fn duration(&self) -> f64;
}

/// The animation of a world in which nothing moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoAnimation;

impl Animation for NoAnimation {
    fn go_to(&mut self, _: &mut Scene, _: f64) -> Result<(), EditError> {
        Ok(())
    }

    fn duration(&self) -> f64 {
        0.0
    }
}
