//! Animation time: play, pause, scrub.

/// Animation time.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Seconds into the animation.
    time: f32,
    /// Whether time goes on by itself.
    pub playing: bool,
    /// Length of the animation in seconds, 0 where nothing is animated.
    length: f32,
}

impl Clock {
    /// At 0, playing where there is something to play.
    ///
    /// ```
    /// let mut clock = scumble_view::Clock::new(4.0);
    /// clock.advance(5.0);
    /// assert_eq!(clock.time(), 1.0, "animations loop");
    /// clock.scrub(3.0);
    /// clock.advance(0.5);
    /// assert_eq!(clock.time(), 3.0, "who scrubs wants it to stand");
    /// ```
    pub fn new(length: f32) -> Clock {
        Clock {
            time: 0.0,
            playing: length > 0.0,
            length: length.max(0.0),
        }
    }

    /// Seconds into the animation.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// Length of the animation in seconds, 0 where nothing is animated.
    pub fn length(&self) -> f32 {
        self.length
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f32) {
        if self.playing && self.length > 0.0 {
            self.time = (self.time + seconds.max(0.0)).rem_euclid(self.length);
        }
    }

    /// Goes to a time, and pauses there.
    pub fn scrub(&mut self, time: f32) {
        self.time = time.clamp(0.0, self.length);
        self.playing = false;
    }

    /// Plays or pauses.
    pub fn toggle(&mut self) {
        self.playing = !self.playing && self.length > 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_that_stands_still_has_no_time() {
        let mut clock = Clock::new(0.0);
        clock.toggle();
        clock.advance(1.0);
        clock.scrub(2.0);
        assert_eq!((clock.time(), clock.playing), (0.0, false));
    }

    #[test]
    fn pausing_keeps_the_time() {
        let mut clock = Clock::new(2.0);
        clock.advance(0.5);
        clock.toggle();
        clock.advance(0.5);
        assert_eq!(clock.time(), 0.5);
        clock.toggle();
        clock.advance(0.5);
        assert_eq!(clock.time(), 1.0);
    }
}
