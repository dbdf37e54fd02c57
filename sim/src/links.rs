//! The torsional springs from a side's gear to its front and rear wheel, with their play.
//!
//! The torque of a link is K phi + D (rotor speed after the tick - wheel speed before it), phi the twist beyond the play. With
//! D = I/dt, I the wheel's inertia, a wheel in the air takes the rotor's speed within one tick and its twist decays by the
//! factor 1 - K dt^2 / I a tick; a wheel held by the ground is damped more. Hence the bound on K: I/dt^2.
//!
//! With play (backlash) a link whose twist is within it passes nothing on, and one beyond it can push but not pull: teeth that
//! part do not hold each other back. Teeth that meet do so without bouncing, as D is that of a plastic impact (an assumption:
//! small steel gears bounce by a fraction of their play).

/// Both links of a side: front, rear.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Links {
    stiffness_n_m_rad: f64,
    damping_n_m_s: f64,
    /// Half of the play.
    half_slack_rad: f64,
    /// Rotor ahead of wheel.
    twist_rad: [f64; 2],
    /// Twist beyond the play.
    strain_rad: [f64; 2],
    /// 1 where the link passes torque on in this tick, else 0.
    engaged: [f64; 2],
}

impl Links {
    /// Links at rest in the middle of their play. `wheel_inertia` is one wheel's, in kg m2.
    pub(crate) fn new(stiffness_n_m_rad: f64, slack_rad: f64, wheel_inertia: f64, dt_s: f64) -> Self {
        Self {
            stiffness_n_m_rad: stiffness_n_m_rad.min(wheel_inertia / (dt_s * dt_s)),
            damping_n_m_s: wheel_inertia / dt_s,
            half_slack_rad: slack_rad / 2.0,
            twist_rad: [0.0; 2],
            strain_rad: [0.0; 2],
            engaged: [1.0; 2],
        }
    }

    /// Begins a tick of `dt_s`: twists by what rotor and wheels turned apart in the one before.
    pub(crate) fn twist(&mut self, dt_s: f64, rotor_rad_s: f64, wheel_rad_s: [f64; 2]) {
        for (i, wheel) in wheel_rad_s.into_iter().enumerate() {
            self.twist_rad[i] += dt_s * (rotor_rad_s - wheel);
            let twist = self.twist_rad[i];
            if self.half_slack_rad > 0.0 {
                self.strain_rad[i] = twist - twist.clamp(-self.half_slack_rad, self.half_slack_rad);
                self.engaged[i] = if self.strain_rad[i] == 0.0 { 0.0 } else { 1.0 };
            } else {
                self.strain_rad[i] = twist;
            }
        }
    }

    /// Lets go of links that would pull if the rotor ended the tick at `after_rad_s`. Whether there were any: the rotor's speed
    /// must then be found anew. At most two times a tick.
    pub(crate) fn part(&mut self, after_rad_s: f64, wheel_rad_s: [f64; 2]) -> bool {
        if self.half_slack_rad == 0.0 {
            return false;
        }
        let torques = self.torques(after_rad_s, wheel_rad_s);
        let mut parted = false;
        for (i, torque) in torques.into_iter().enumerate() {
            if torque * self.strain_rad[i] < 0.0 {
                (self.strain_rad[i], self.engaged[i]) = (0.0, 0.0);
                parted = true;
            }
        }
        parted
    }

    /// Torque on both wheels together if the rotor stands still at the end of the tick, in N m.
    pub(crate) fn torque_at_rest(&self, wheel_rad_s: [f64; 2]) -> f64 {
        let [front, rear] = self.strain_rad;
        let wheels = self.engaged[0] * wheel_rad_s[0] + self.engaged[1] * wheel_rad_s[1];
        self.stiffness_n_m_rad * (front + rear) - self.damping_n_m_s * wheels
    }

    /// How much more it is for each rad/s of the rotor, in N m s/rad.
    pub(crate) fn torque_per_speed(&self) -> f64 {
        (self.engaged[0] + self.engaged[1]) * self.damping_n_m_s
    }

    /// Torque on each wheel if the rotor ends the tick at `after_rad_s`, in N m.
    pub(crate) fn torques(&self, after_rad_s: f64, wheel_rad_s: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let damping = self.damping_n_m_s * (after_rad_s - wheel_rad_s[i]);
            self.engaged[i] * (self.stiffness_n_m_rad * self.strain_rad[i] + damping)
        })
    }

    /// Energy in the springs half a tick after the twists were taken, in J: where the wheels' speeds, which belong to the end of the
    /// tick, and the twists, which are taken at its beginning, make a sum that a swing leaves alone (to second order in the tick).
    pub(crate) fn energy_j(&self, dt_s: f64, rotor_rad_s: f64, wheel_rad_s: [f64; 2]) -> f64 {
        let squares = [0, 1].map(|i| {
            let twist = self.twist_rad[i] + 0.5 * dt_s * (rotor_rad_s - wheel_rad_s[i]);
            let strain = twist - twist.clamp(-self.half_slack_rad, self.half_slack_rad);
            strain * strain
        });
        0.5 * self.stiffness_n_m_rad * (squares[0] + squares[1])
    }
}
