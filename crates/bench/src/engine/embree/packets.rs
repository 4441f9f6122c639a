//! Packets of eight or sixteen rays. The time includes bringing rays into the layout of a packet,
//! and answers out of it.

use std::sync::Arc;

use kinetree::Coherence;

use super::api::{Api, Arguments, Handle, INVALID, Packet, RayQueryFlags, TraceN};
use super::denormals::NoDenormals;
use crate::engine::interface::{Batch, Mode};
use crate::ray::{Answer, Ray};

/// The two calls for packets of `N` rays, and the scene.
pub(super) struct Packets<const N: usize> {
    suffix: &'static str,
    intersect: TraceN,
    occluded: TraceN,
    /// The scene is owned by the tree that owns this value.
    scene: Handle,
    _api: Arc<Api>,
}

// SAFETY: a committed scene may be traced from all threads.
unsafe impl<const N: usize> Send for Packets<N> {}
// SAFETY: as above.
unsafe impl<const N: usize> Sync for Packets<N> {}

impl Packets<8> {
    pub(super) fn x8(api: &Arc<Api>, scene: Handle) -> Self {
        Self { suffix: "x8", intersect: api.intersect8, occluded: api.occluded8, scene, _api: Arc::clone(api) }
    }
}

impl Packets<16> {
    pub(super) fn x16(api: &Arc<Api>, scene: Handle) -> Self {
        Self { suffix: "x16", intersect: api.intersect16, occluded: api.occluded16, scene, _api: Arc::clone(api) }
    }
}

/// The active rays of a packet: all bits set, or none.
#[repr(align(64))]
struct Valid<const N: usize>([i32; N]);

/// Pixels along the side of a tile of primary rays.
const TILE: usize = 8;

/// The order in which the rays of a tile are put into packets: blocks of 4 by 4 pixels, the upper
/// half of a block before the lower, so that packets of eight are 4 by 2.
const ORDER: [usize; TILE * TILE] = {
    let mut order = [0; TILE * TILE];
    let mut at = 0;
    while at < order.len() {
        let (block, pixel) = (at / 16, at % 16);
        let (x, y) = (block % 2 * 4 + pixel % 4, block / 2 * 4 + pixel / 4);
        order[at] = y * TILE + x;
        at += 1;
    }
    order
};

impl<const N: usize> Packets<N> {
    /// Traces rays in packets by `call`, then passes each ray's index, its lane and the packet to
    /// `take`.
    fn run(&self, rays: &[Ray], call: TraceN, coherence: Coherence, mut take: impl FnMut(usize, usize, &Packet<N>)) {
        let _no_denormals = NoDenormals::begin();
        let coherent = coherence == Coherence::Coherent;
        let flags = if coherent { RayQueryFlags::COHERENT } else { RayQueryFlags::NONE };
        let mut arguments = Arguments::with_flags(flags);
        let mut packet = Packet::<N> {
            origin: [[0.0; N]; 3],
            t_near: [0.0; N],
            direction: [[0.0; N]; 3],
            time: [0.0; N],
            t_far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [INVALID; N],
            geometry: [INVALID; N],
            instances: [[INVALID; N]; 2],
        };
        let whole_tiles = rays.len() / ORDER.len() * ORDER.len();
        for first in (0..rays.len()).step_by(N) {
            let count = N.min(rays.len() - first);
            let number = |lane: usize| {
                let index = first + lane;
                if coherent && index < whole_tiles {
                    index / ORDER.len() * ORDER.len() + ORDER[index % ORDER.len()]
                } else {
                    index
                }
            };
            let mut valid = Valid([0; N]);
            for lane in 0..count {
                let ray = &rays[number(lane)];
                for axis in 0..3 {
                    packet.origin[axis][lane] = ray.origin[axis];
                    packet.direction[axis][lane] = ray.direction[axis];
                }
                packet.t_far[lane] = ray.t_max;
                valid.0[lane] = -1;
            }
            packet.t_near = [0.0; N];
            packet.geometry = [INVALID; N];
            // SAFETY: the scene is committed and alive, `valid` and the packet have the layout and
            // at least the alignment that Embree requires for `N` rays, and the arguments are its
            // defaults except for the flags.
            unsafe { call(valid.0.as_ptr(), self.scene, (&raw mut packet).cast(), &mut arguments) };
            (0..count).for_each(|lane| take(number(lane), lane, &packet));
        }
    }
}

impl<const N: usize> Batch for Packets<N> {
    fn suffix(&self) -> &'static str {
        self.suffix
    }

    fn mode(&self) -> Mode {
        Mode::Packet
    }

    fn suits(&self, coherence: Coherence) -> bool {
        coherence == Coherence::Coherent
    }

    fn closest(&self, rays: &[Ray], answers: &mut [Answer], coherence: Coherence) {
        self.run(rays, self.intersect, coherence, |number, lane, packet| {
            let (t, u, v) = (packet.t_far[lane], packet.u[lane], packet.v[lane]);
            let (primitive, mesh) = (packet.primitive[lane], packet.geometry[lane]);
            answers[number] = if mesh == INVALID { Answer::MISS } else { Answer { t, u, v, primitive, mesh } };
        });
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        self.run(rays, self.occluded, coherence, |number, lane, packet| answers[number] = packet.t_far[lane] < 0.0);
    }
}
