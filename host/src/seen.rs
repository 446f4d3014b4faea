//! What the monitor sees, for who takes it besides: a file, and programs that connect.

/// What a line of the monitor says.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(feature = "mcap"),
    expect(dead_code, reason = "a build without the feature writes nothing")
)]
pub struct Seen<'a> {
    /// The board's time, s.
    pub t_s: f64,
    /// x and y, m.
    pub place_m: [f64; 2],
    /// The angle by each pair, rad.
    pub theta_rad: [f64; 2],
    /// g_p, m.
    pub parity_m: f64,
    /// The status' bits, and their names.
    pub status: (u32, &'a str),
}

#[cfg(feature = "mcap")]
impl<'a> Seen<'a> {
    /// As a message has it.
    pub fn state(&self) -> bag::State<'a> {
        let [x_m, y_m] = self.place_m;
        bag::State {
            t_s: self.t_s,
            x_m,
            y_m,
            theta_rad: self.theta_rad,
            parity_m: self.parity_m,
            status: self.status,
        }
    }

    /// When the board's time was zero, ns since 1970, if it is seen now.
    ///
    /// # Errors
    /// The clock stands before 1970, or after 2554.
    pub fn zero_ns(&self) -> anyhow::Result<u64> {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH)?;
        Ok(u64::try_from(now.as_nanos())?.saturating_sub((self.t_s * 1e9) as u64))
    }
}
