//! `--record`: the poses of the session and the fly-by as a recording of the layout.

use anyhow::Result;
use board_link::Simulated;
use command_line::destination::Destination;
use courier_sensor::frame::{Frame, RawFrame, Status};
use courier_sensor::link::telemetry::Sample;
use effects::motion::Pose;
use hal_sim::record::meta;
use hal_sim::spec::CourierSpec;
use hal_sim::world::Witness;
use recording::{Row, Writer};

/// Writes nothing if it was given no folder.
pub struct Recorder(Option<Writer>);

impl Recorder {
    /// Begins a recording of this courier.
    ///
    /// # Errors
    /// As [`Destination::create`].
    pub fn create(to: Option<&Destination>, spec: &CourierSpec) -> Result<Self> {
        let create = |to: &Destination| to.create(&meta(spec));
        Ok(Self(to.map(create).transpose()?))
    }

    /// Whether anything is written.
    pub fn is_on(&self) -> bool {
        self.0.is_some()
    }

    /// A still pose; run `scatter`.
    pub fn pose(&mut self, board: &Simulated, sample: &Sample, witness: &Witness) -> Result<()> {
        let (quadrature_counts, electrode_counts) = sample.raw.unwrap_or_default();
        let frame = Frame {
            status: sample.status.unwrap_or_default(),
            raw: RawFrame {
                quadrature_counts,
                electrode_counts,
                ..RawFrame::default()
            },
            ..Frame::default()
        };
        let temperature_c = board
            .world
            .with_courier(|courier| courier.sample().temperature_c);
        let time_s = witness.time_ns as f64 * 1.0e-9;
        let teeth = witness.teeth;
        self.push("scatter", time_s, &frame, teeth, Some(temperature_c), None)
    }

    /// An instant of the fly-by, with the interferometer; run `flyby_y`.
    pub fn flight(&mut self, frame: &Frame, witness: &Witness) -> Result<()> {
        let time_s = witness.time_ns as f64 * 1.0e-9;
        self.push(
            "flyby_y",
            time_s,
            frame,
            witness.teeth,
            None,
            Some(witness.reference),
        )
    }

    fn push(
        &mut self,
        run: &str,
        t_s: f64,
        frame: &Frame,
        teeth: [i32; 4],
        temperature_c: Option<f64>,
        reference: Option<Pose>,
    ) -> Result<()> {
        let Some(writer) = &mut self.0 else {
            return Ok(());
        };
        let raw = &frame.raw;
        let electrodes = if frame.status.contains(Status::BEACON_MISSING) {
            [0; 4]
        } else {
            raw.electrode_counts
        };
        writer.push(&Row {
            t_s,
            run,
            quadrature_counts: raw.quadrature_counts.map(|pair| Some(pair.map(f64::from))),
            teeth: teeth.map(Some),
            electrode_counts: Some(electrodes.map(f64::from)),
            temperature_c,
            reference: reference.map_or([None; 3], |pose| {
                [pose.x_m, pose.y_m, pose.theta_rad].map(Some)
            }),
            ..Row::default()
        })?;
        Ok(())
    }

    /// Puts the recording in its place.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(self) -> Result<()> {
        self.0.map_or(Ok(()), |writer| Ok(writer.finish()?))
    }
}
