#!/usr/bin/env python3
"""An independent plant of the courier's sensors: true pose(t) -> coils and diode -> counts.  python make.py --set K --out DIR"""
import argparse, json, math, os, sys, time, zlib
for v in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"): os.environ.setdefault(v, "1")
import numpy as np

RHO = 1.016e-3
F = 2 * np.pi / RHO
UM = 1e-6
CATALOGUE = ["lateral_dependence", "extra_harmonics", "tooth_variation", "angle_dependence", "psd_nonlinearity",
             "psd_misalignment", "thermal_drift", "velocity_lag", "psd_latency", "hysteresis", "gap_variation",
             "beacon_vibration", "axis_skew", "cycle_slip", "outlier_bursts", "excess_noise", "adc_clipping",
             "quadrature_drift", "span_error"]
NEED_BEACON = {"psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew", "lateral_dependence"}
NOT_POSITIONS = {"adc_clipping", "gap_variation"}
NOT_REFERENCE = NEED_BEACON | {"angle_dependence", "span_error"}
UNSCALED = {"cycle_slip", "outlier_bursts", "excess_noise"}

T_, TI, PL, DE, TH, SP, OW, LA, FR, AM, DI = ("time", "time", "place|platen", "deflection", "theta|angle", "speed",
        "own phase|tooth phase", "lateral", "frequency|vibration", "amplitude", "direction")
# name: (description, places, forms)
UNLISTED = {
 "mains_hum": ("50/60 Hz mains hum (with third harmonic) picked up additively by one segment's coil amplifiers", [FR, TI, OW], "bnr"),
 "mux_crosstalk": ("crosstalk in the converter's multiplexer: a segment of one axis leaks into a segment of the other axis", [OW, LA], "bn"),
 "sampling_jitter": ("random jitter of the sampling instant, segment by segment: noise that grows with speed and is nil at rest", [SP, TI], "bnpr"),
 "courier_tilt": ("air-bearing courier tilts (mrad/100) on platen waviness of 2 to 6 mm wavelength: the beacon's image moves", [PL, DE, TH], "b"),
 "etalon_fringes": ("interference fringes in the diode's cover glass: spot position error periodic in deflection, not in the tooth pitch", [DE, PL], "bp"),
 "glint": ("a reflection inside the beacon tube reaches the diode only in a narrow range of deflection", [DE, PL], "bp"),
 "ambient_flicker": ("100/120 Hz lamp light on the diode, centred: the sum and with it the gain of the deflection are modulated", [FR, TI, DE, AM], "bp"),
 "dark_offset_led_sag": ("uncompensated dark current while the beacon's LED sags: apparent shift goes as the inverse of the sum", [TI, AM, DE], "bp"),
 "beacon_relaxation": ("the beacon's post was clamped shortly before and relaxes: exponential creep with two time constants", [TI], "bp"),
 "beacon_bump": ("the beacon is knocked once or twice during the recording and stays displaced", [TI], "bp"),
 "loose_segment": ("a segment is loose in its potting and vibrates at a narrow frequency in still and motion alike", [FR, TI], "bnp"),
 "bearing_lift": ("the courier lifts with speed squared; segments shift by an amount even in speed", [SP], "bnpr"),
 "magnetised_spot": ("a magnetised screw under the platen adds a constant field to the coils near one place", [PL, OW], "bnr"),
 "beacon_turbulence": ("hot air between beacon and diode: broadband coloured wander of 0.2 to 5 Hz", [TI, FR], "bp"),
 "electrode_contact": ("one electrode's solder joint is intermittent: its gain is a per cent low for stretches of seconds", [TI, DE, AM], "bp"),
 "firmware_boundary": ("firmware corrects the second order only within its table's range of teeth; past the boundary it does not", [PL, OW], "bnpr"),
 "bandwidth_switch": ("amplifier switches to a wide-band range above a speed; its two channels then differ in gain and in phase", [SP, OW], "bnr"),
 "sequential_sampling": ("sine is converted before and cosine after the nominal moment: quadrature error grows with speed, mean lag nil", [SP, OW], "bnr"),
}

def lu(r, a, b): return float(np.exp(r.uniform(np.log(a), np.log(b))))
def sg(r): return float(r.choice([-1.0, 1.0]))
def subset(r, n=4, lo=1):
    k = int(r.integers(lo, n + 1)); return sorted(int(i) for i in r.choice(n, k, replace=False))

# ------------------------------------------------------------------------------------------------ hardware
def draw_hw(r, form, names):
    H = {"form": form}
    H["beacon"] = form == "beacon" or (form == "positions" and (bool(NEED_BEACON & set(names)) or any(n in UNLISTED and "b" in UNLISTED[n][2] and not set("nr") & set(UNLISTED[n][2]) for n in names) or r.random() < .55))
    H["ls"] = 9.7e-3; H["lo"] = float(r.uniform(2.5e-3, 6.5e-3))
    H["A0"] = float(round(r.uniform(20000, 28000), -2))
    if "gap_variation" in names: H["A0"] = float(round(r.uniform(20000, 21500), -2))
    H["noise"] = float(round(r.uniform(10, 25), 1)); H["pos_noise"] = float(round(lu(r, .05e-6, .3e-6), 9))
    if "excess_noise" in names: H["noise"] = float(round(r.uniform(16, 25), 1)); H["pos_noise"] = float(round(r.uniform(.12e-6, .3e-6), 9))
    H["A"] = [H["A0"] * float(r.uniform(.95, 1.06)) for _ in range(4)]
    H["g"] = [sg(r) * float(r.uniform(.012, .053)) for _ in range(4)]
    H["psi"] = [sg(r) * math.radians(lu(r, .4, 3.)) for _ in range(4)]
    H["off"] = [[sg(r) * float(r.uniform(.0015, .005)) for _ in range(2)] for _ in range(4)]
    H["h3"] = [float(r.uniform(.0, .006)) for _ in range(4)]
    H["mount"] = [float(r.uniform(-12e-6, 12e-6)) for _ in range(4)]
    H["h_nom"] = float(round(r.uniform(28e-3, 50e-3), 4)); H["h"] = H["h_nom"] * (1 + sg(r) * lu(r, .002, .03))
    H["lx_nom"] = float(round(r.uniform(86e-3, 94e-3), 4)); H["lx"] = H["lx_nom"] + float(r.uniform(-4e-4, 4e-4))
    H["ly_nom"] = float(round(r.uniform(-15e-3, 15e-3), 4)); H["ly"] = H["ly_nom"] + float(r.uniform(-4e-4, 4e-4))
    fs = float(r.uniform(6.8e-3, 8.5e-3)); H["tfs"] = float(round(fs / H["h_nom"], 4))
    H["S0"] = float(round(r.uniform(28000, 36000), -2)); H["S"] = H["S0"] * float(r.uniform(.95, 1.03)); H["psd_noise"] = float(round(r.uniform(.8, 1.8), 2))
    H["bpos"] = [float(r.uniform(3e-3, 7e-3) + r.choice([0, 0, 12e-3])), float(r.uniform(3e-3, 7e-3) + r.choice([0, 0, 10e-3]))]  # courier centre under the beacon at theta 0
    H["o"] = [H["bpos"][0] - H["lx"], H["bpos"][1] - H["ly"]]
    H["cmd_amp"] = [float(r.uniform(8e-6, 22e-6)) for _ in range(2)] + [float(r.uniform(4e-5, 2e-4))]
    return H

# ------------------------------------------------------------------------------------------------ motion
class Plan:
    """still samples hold a pose; moving stretches are analytic functions of time and may be asked at any shifted time"""
    def __init__(s): s.t = []; s.run = []; s.still = []; s.cmd_still = []; s.moves = []; s.n = 0; s.now = 0.; s.groups = []
    def add_still(s, name, tt, pose, cmd):
        s.t.append(tt); s.run += [name] * len(tt); s.still.append(np.tile(pose, (len(tt), 1))); s.cmd_still.append(np.tile(cmd, (len(tt), 1))); s.n += len(tt); s.now = tt[-1]
    def add_move(s, name, tt, fn):
        s.moves.append((s.n, s.n + len(tt), fn)); s.t.append(tt); s.run += [name] * len(tt)
        s.still.append(np.full((len(tt), 3), np.nan)); s.cmd_still.append(np.full((len(tt), 3), np.nan)); s.n += len(tt); s.now = tt[-1]
    def done(s):
        s.t = np.concatenate(s.t); s.still = np.concatenate(s.still); s.cmd_still = np.concatenate(s.cmd_still); s.T = s.t[-1]
        s.run = np.array(s.run); s.P0 = s.pose(0.); s.cmd = s.cmd_still.copy()
        for a, b, fn in s.moves: s.cmd[a:b] = fn(s.t[a:b])[1]
        s.V = (s.pose(1e-4) - s.pose(-1e-4)) / 2e-4
    def pose(s, dt):
        P = s.still.copy()
        for a, b, fn in s.moves: P[a:b] = fn(s.t[a:b] + (dt[a:b] if np.ndim(dt) else dt))[0]
        return P

def scurve(D, v, ta):
    """distance along the way: raised-cosine ramps of time ta about a constant speed v"""
    tc = D / v - ta; T = tc + 2 * ta
    def ramp(t): return v / 2 * (t - ta / np.pi * np.sin(np.pi * t / ta))
    def s(t):
        t = np.clip(t, 0, T)
        return np.where(t < ta, ramp(np.minimum(t, ta)), np.where(t < ta + tc, v * ta / 2 + v * (t - ta), D - ramp(np.clip(T - t, 0, ta))))
    return s, T

def draw_plan(r, H, law, second):
    """law: the motion's settings drawn once for both recordings; r: this recording's own generator"""
    P = Plan(); ref = H["form"] == "reference"; amp = H["cmd_amp"]; shr = .97 if second else 1.
    def still_err(): return np.array([r.normal(0, amp[0]) * 1.5, r.normal(0, amp[1]) * 1.5, r.normal(0, amp[2])]) * (0 if False else 1)
    def line(name, start, D, v, axis, back, fs, ta):
        s, T = scurve(D, v, ta); t0 = P.now + r.uniform(.4, 1.2); start = np.array(start, float); end = start.copy(); end[axis] += D
        a, b = (end, start) if back else (start, end)
        ph = r.uniform(0, 6.28, 6); fr = r.uniform(.2, .6, 3)
        def fn(t):
            u = s(t - t0) / D; c = a[None] + (b - a)[None] * u[:, None]; e = np.zeros_like(c); w = np.sin(np.pi * np.clip(u, 0, 1)) ** 2
            for k in range(3):
                if ref and k: continue
                e[:, k] = amp[k] * (.6 * np.sin(F * c[:, min(axis, 1)] + ph[k]) + np.sin(2 * np.pi * fr[k] * np.clip(t - t0, 0, T) + ph[3 + k]))
            return c + e, c
        dw = .03; tt = np.arange(t0 - dw, t0 + T + dw, 1 / fs); P.add_move(name, tt, fn)
    def under(c, th):
        R = np.array([[math.cos(th), -math.sin(th)], [math.sin(th), math.cos(th)]])
        xy = R @ (np.array(c) + [H["lx"], H["ly"]]) + H["o"]; return np.array([xy[0], xy[1], th])
    def poses(name, n, fn):
        for k in range(n):
            c = fn(); pose = c + (still_err() if not ref else np.array([r.normal(0, amp[0]), 0, 0]))
            t0 = P.now + law["dwell"] * r.uniform(.7, 1.3); m = law["m"] if law["m_fixed"] else int(r.integers(2, law["m"] + 1))
            P.add_still(name, t0 + np.arange(m) / law["fs_still"], pose, c)
    def scatter(n):
        def one():
            th = 0. if ref else r.uniform(-1, 1) * math.radians(.5) * shr
            return np.array([5 * RHO + r.uniform(-5, 5) * RHO * shr, law["y0"] if ref else 5 * RHO + r.uniform(-5, 5) * RHO * shr, th])
        poses("scatter", n, one)
    def beacon(n): poses("beacon", n, lambda: under(r.uniform(-1, 1, 2) * RHO * shr, r.uniform(-1, 1) * math.radians(1.5) * shr))
    sh = lambda a: float(r.uniform(0, a)) if second else 0.
    def flyby(axis, slow=False):
        st = [law["fx"][0], law["fx"][1], law["fth"]] if axis == 0 else [law["fy"][0], law["fy"][1], law["fth"]]
        if ref: st[1] = law["y0"]; st[2] = 0.
        k = sh(4e-4); st[axis] += k; D = .040 - 2 * k; nm = "flyby_" + "xy"[axis]
        if not ref: st[1 - axis] += (r.uniform(-1, 1) * 1.5e-4 if second else 0)
        if slow: line(nm + "_slow", st, D, law["v_slow"], axis, bool(r.integers(2)), law["fs_slow"], .1)
        else:
            line(nm, st, D, .050, axis, False, law["fs_fly"], law["ta"]); line(nm + "_back", st, D, .050, axis, True, law["fs_fly"], law["ta"])
    def bpass(axis):
        c = under([0, 0], law["bth"]); k = sh(2e-4); c[axis] -= .004 - k; c[1 - axis] += law["boff"]; nm = "beacon_" + "xy"[axis]
        for q in range(law["bpass_rep"]):
            line(nm, c, .008 - 2 * k, .020, axis, False, law["fs_bp"], .05); line(nm + "_back", c, .008 - 2 * k, .020, axis, True, law["fs_bp"], .05)
    def spin():
        T = law["spin_T"]; t0 = P.now + .8; A = math.radians(1.2) * shr; c0 = r.uniform(-3e-5, 3e-5, 2); ph = r.uniform(0, 6.28, 3)
        piv = np.array([H["lx"], H["ly"]])
        def fn(t):
            u = np.clip((t - t0) / T, 0, 1); th = A * np.sin(2 * np.pi * law["spin_n"] * (u - np.sin(2 * np.pi * u) / (2 * np.pi)))
            cx, sx = np.cos(th), np.sin(th); q = c0 + piv
            c = np.stack([cx * q[0] - sx * q[1] + H["o"][0], sx * q[0] + cx * q[1] + H["o"][1], th], 1); e = np.zeros_like(c)
            for k in range(2): e[:, k] = amp[k] * np.sin(F * c[:, k] + ph[k])
            return c + e, c
        P.add_move("spin", np.arange(t0 - .02, t0 + T + .02, 1 / law["fs_spin"]), fn)
    def still():
        c = (np.array([5 * RHO, law["y0"], 0.]) if ref else under([0, 0], 0.) if H["beacon"] and law["still_b"] else np.array([5 * RHO + r.uniform(-RHO, RHO), 5 * RHO + r.uniform(-RHO, RHO), 0.]))
        n = law["still_n"]; pose = c + (np.array([r.normal(0, amp[0]), 0, 0]) if ref else still_err())
        P.add_still("still", P.now + .6 + np.arange(n) / law["fs_stillrun"], pose, c)
    for item in law["order"]:
        k, _, a = item.partition(":")
        {"scatter": lambda: scatter(int(a)), "beacon": lambda: beacon(int(a)), "flyx": lambda: flyby(0), "flyy": lambda: flyby(1), "slow": lambda: flyby(0 if ref else 1, True),
         "bx": lambda: bpass(0), "by": lambda: bpass(1), "spin": spin, "still": still}[k]()
    P.done(); return P

def draw_motion(r, H, names):
    ref = H["form"] == "reference"
    L = dict(m=int(r.integers(2, 9)), m_fixed=bool(r.integers(2)), dwell=float(r.uniform(.35, .8)), fs_still=float(r.choice([100, 200, 250, 500])),
             fs_fly=float(r.choice([400, 500, 800, 1000])), fs_slow=float(r.choice([50, 100, 200])), v_slow=float(r.uniform(5e-3, 10e-3)), fs_bp=float(r.choice([400, 500, 800, 1000])), ta=float(r.uniform(.05, .15)),
             fs_spin=float(r.choice([100, 200])), spin_T=float(r.uniform(4, 8)), spin_n=int(r.integers(1, 4)), fs_stillrun=float(r.choice([200, 500, 1000])),
             still_n=int(r.integers(400, 1200)), still_b=bool(r.random() < .7), bth=float(r.uniform(-4e-3, 4e-3)), boff=float(r.uniform(-4e-4, 4e-4)), fth=float(r.uniform(-5e-3, 5e-3)), y0=float(r.uniform(2e-3, 8e-3)), bpass_rep=int(r.integers(1, 3)))
    c = 5 * RHO
    L["fx"] = [c - .020 + float(r.uniform(-2e-3, 2e-3)), c + float(r.uniform(-3e-3, 3e-3))]; L["fy"] = [c + float(r.uniform(-3e-3, 3e-3)), c - .020 + float(r.uniform(-2e-3, 2e-3))]
    ns = int(r.integers(300, 520)); nb = int(r.integers(300, 520))
    if ref: L["m"] = max(L["m"], 4); ns = int(r.integers(400, 700))
    moving = {"velocity_lag", "hysteresis", "sampling_jitter", "bearing_lift", "bandwidth_switch", "sequential_sampling", "psd_latency"} & set(names)
    while True:                                            # keep the whole within 3,000 to 12,000 samples
        mm = L["m"] if L["m_fixed"] else (2 + L["m"]) / 2
        est = mm * (ns + (nb if H["beacon"] else 0)) + (2 if ref else 4) * .9 * L["fs_fly"] + .04 / L["v_slow"] * L["fs_slow"] + (4 * L["bpass_rep"] * .5 * L["fs_bp"] if H["beacon"] else 0) + L["spin_T"] * L["fs_spin"] + L["still_n"]
        if est < 11000: break
        if mm > 3.2: L["m"] -= 1
        else: ns = int(ns * .9); nb = int(nb * .9); L["bpass_rep"] = 1
    order = []
    a = int(ns * r.uniform(.4, .7)); order.append([f"scatter:{a}"]); order.append([f"scatter:{ns - a}"])
    fl = ["flyx"] if ref else ["flyx", "flyy"]
    if r.random() < .8 or moving: fl.append("slow")
    order.append(fl)
    if H["beacon"]:
        b = int(nb * r.uniform(.4, .7)); order += [[f"beacon:{b}", "bx"], [f"beacon:{nb - b}", "by"]]
    if not ref and (r.random() < .85 or {"angle_dependence", "span_error"} & set(names)): order.append(["spin"])
    if r.random() < .85: order.append(["still"])
    ix = r.permutation(len(order)); L["order"] = [i for k in ix for i in order[k]]
    return L

# ------------------------------------------------------------------------------------------------ laws of the effects (hardware part), sized ~1 um at scale 1
def draw_law(r, name, H, form):
    nseg = 1 if form == "reference" else 4
    S = lambda lo=1: [0] if nseg == 1 else subset(r, 4, lo)
    per = lambda segs, f: {str(i): f() for i in segs}
    if name == "lateral_dependence": return dict(seg=per(S(2), lambda: [float(r.normal(0, 1.2) + sg(r) * .6), float(r.uniform(0, 6.28)), float(r.normal(0, .5)), float(r.uniform(0, 6.28)), float(r.uniform(.0, .5))]), am=float(r.uniform(0, .03)))
    if name == "extra_harmonics":
        ords = sorted(int(k) for k in r.choice([2, 4, 6, 7, 9, 11], int(r.integers(1, 4)), replace=False))
        return dict(orders=ords, seg=per(S(2), lambda: [[float(r.normal(0, .006)) for _ in range(4)] for _ in ords]))
    if name == "tooth_variation": return dict(seed=int(r.integers(1 << 30)), n_own=int(r.integers(3, 8)), n_lat=int(r.integers(2, 7)), mix=float(r.uniform(0, .5)), rms_um=1.9)
    if name == "angle_dependence": return dict(seg=per(S(2), lambda: [float(r.normal(0, 3e-4)), float(r.normal(0, .35)), float(r.normal(0, .35)), float(r.uniform(5e-4, 3e-3)), float(r.uniform(5e-4, 3e-3))]))
    if name == "psd_nonlinearity": return dict(k3=[float(r.normal(0, 8e-3)) for _ in range(2)], k2=[float(r.normal(0, 2e-3)) for _ in range(2)], kx=[float(r.normal(0, 4e-3)) for _ in range(2)], pin=float(r.normal(0, 6e-3)), sat=float(r.uniform(.0, .3)))
    if name == "psd_misalignment": return dict(gain=sg(r) * float(r.uniform(1e-3, 4e-3)), rot=float(r.normal(0, 4e-3)), shear=0.)
    if name == "thermal_drift": return dict(c=[float(r.normal(0, .4)) for _ in range(4)], alpha=float(r.uniform(8e-6, 24e-6)) * 1., lag_s=float(r.choice([0, 0, r.uniform(1, 8)])), psd=[float(r.normal(0, .25)) for _ in range(2)], h=float(r.normal(0, 2e-5)))
    if name == "velocity_lag": return dict(tau=[float(r.uniform(5e-6, 8e-5)) for _ in range(4)], eddy=[float(r.uniform(0, .5)) for _ in range(4)], skew=float(r.uniform(0, .5)))
    if name == "psd_latency": return dict(tau=sg(r) * 1e-4, filt=float(r.uniform(0, 1)))
    if name == "hysteresis":
        kind = str(r.choice(["dahl", "dahl2", "play"]))
        return dict(kind=kind, b=[float(r.uniform(.1, 1.8)) for _ in range(4)], sigma=[lu(r, 8e-6, 6e-5), lu(r, 1e-4, 5e-4)], w=float(r.uniform(.5, .9)), thr=[lu(r, 4e-6, 2e-4) for _ in range(5)])
    if name == "gap_variation": return dict(seed=int(r.integers(1 << 30)), rms=float(r.uniform(1.4e-5, 2.2e-5)), h3=[[float(r.normal(0, .008)) for _ in range(4)] for _ in range(4)], k=[float(r.normal(0, .008)) for _ in range(4)], lmin=float(r.uniform(12e-3, 20e-3)))
    if name == "beacon_vibration":
        n = int(r.integers(1, 4)); return dict(f=[lu(r, 7, 330) for _ in range(n)], a=[float(r.uniform(.4, 1.4)) for _ in range(n)], dir=[float(r.uniform(0, 3.14)) for _ in range(n)], am=float(r.uniform(0, .4)))
    if name == "axis_skew":
        k = int(r.integers(3)); return dict(eps=0. if k == 0 else sg(r) * float(r.uniform(2e-4, 6e-4)), sq=0. if k == 1 else sg(r) * float(r.uniform(2e-4, 8e-4)), common=float(r.uniform(-1e-5, 1e-5)))
    if name == "cycle_slip":
        segs = [0] if nseg == 1 else [int(i) for i in r.choice(4, int(r.choice([1, 1, 2])), replace=False)]
        return dict(segs=segs, teeth=[int(r.choice([-2, -1, -1, 1, 1, 2, 3])) for _ in segs])
    if name == "outlier_bursts":
        tgt = "psd" if H["beacon"] and r.random() < .3 else "quad"
        return dict(target=tgt, segs=S(), frac=lu(r, .01, .09), mult=[10, 100] if r.random() < .6 else [20, 80], blen=int(r.integers(1, 13)))
    if name == "excess_noise":
        tgt = "psd" if H["beacon"] and r.random() < .35 else "quad"
        return dict(target=tgt, segs=list(range(nseg)) if r.random() < .6 else S(), k=float(r.uniform(1.6, 6)))
    if name == "adc_clipping":
        segs = S(); return dict(kind=str(r.choice(["hard", "range", "soft"])), seg=per(segs, lambda: [float(r.uniform(.8, 1.2)), float(r.uniform(.8, 1.2)), str(r.choice(["both", "both", "both", "s", "c"]))]), knee=float(r.uniform(10, 24)))
    if name == "quadrature_drift":
        segs = S(); kinds = list(r.choice(["offset", "gain", "phase"], int(r.integers(1, 4)), replace=False))
        return dict(seg=per(segs, lambda: dict(os=float(r.normal(0, .006)) if "offset" in kinds else 0., oc=float(r.normal(0, .006)) if "offset" in kinds else 0., g=float(r.normal(0, .012)) if "gain" in kinds else 0., psi=float(r.normal(0, .012)) if "phase" in kinds else 0.)), tc=float(r.uniform(.06, .3)), kinds=[str(k) for k in kinds])
    if name == "span_error": return dict(a=[float(r.normal(0, 6e-5)) for _ in range(4)], lo=float(r.normal(0, 6e-5)))
    # ---- unlisted
    one = lambda: 0 if nseg == 1 else int(r.integers(4))
    if name == "mains_hum": return dict(seg=one(), f=float(r.choice([50, 60])) * float(1 + r.normal(0, 4e-4)), a=[float(r.normal(0, .012)), float(r.normal(0, .012))], h3=float(r.uniform(0, .4)))
    if name == "mux_crosstalk":
        i = int(r.integers(4)); j = int(r.choice([1, 3] if i in (0, 2) else [0, 2])); return dict(to=i, frm=j, eps=[sg(r) * float(r.uniform(.006, .015)), float(r.normal(0, .006))])
    if name == "sampling_jitter": return dict(sigma=[5e-5 * float(r.uniform(.6, 1.4)) for _ in range(4)])
    if name == "courier_tilt": return dict(k=[[float(q) for q in (lambda l, a: (2 * np.pi / l * np.cos(a), 2 * np.pi / l * np.sin(a)))(r.uniform(2e-3, 6e-3), r.uniform(0, 3.14))] + [float(r.uniform(0, 6.28)), float(r.normal(0, 1)), float(r.normal(0, 1))] for _ in range(5)])
    if name == "etalon_fringes":
        while True:
            lam = [float(r.uniform(2.6e-4, 8e-4)) for _ in range(2)]
            if all(min(abs(l / RHO * k - 1) for k in (1, 2, 3, 4)) > .06 for l in lam): break
        return dict(lam=lam, a=[float(r.uniform(.6, 1.4)) for _ in range(2)], ph=[float(r.uniform(0, 6.28)) for _ in range(2)], fin=float(r.uniform(0, .4)))
    if name == "glint": return dict(c=[float(r.uniform(-7e-4, 7e-4)), float(r.uniform(-7e-4, 7e-4))], w=[float(r.uniform(1.8e-4, 4e-4)) for _ in range(2)], a=[float(r.normal(0, 3)) + sg(r), float(r.normal(0, 3)) + sg(r)])
    if name == "ambient_flicker": return dict(f=float(r.choice([100, 120])) * float(1 + r.normal(0, 3e-4)), m=.002, even=float(r.uniform(0, .3)))
    if name == "dark_offset_led_sag": return dict(o=[sg(r) * float(r.uniform(10, 30)) for _ in range(2)], sag=float(r.uniform(.25, .5)), tau=float(r.uniform(.1, .5)), cyc=float(r.uniform(.1, .25)))
    if name == "beacon_relaxation": return dict(a=[float(r.normal(0, 3)) + sg(r), float(r.normal(0, 3)) + sg(r)], tau=[float(r.uniform(15, 50)), float(r.uniform(100, 250))], w=float(r.uniform(.3, .7)))
    if name == "beacon_bump": return dict(n=int(r.integers(1, 3)), size=[float(r.uniform(1, 3)), float(r.uniform(1, 3))])
    if name == "loose_segment": return dict(seg=one(), f=lu(r, 12, 240), am=float(r.uniform(0, .3)))
    if name == "bearing_lift": return dict(k=[float(r.normal(0, 1.)) for _ in range(4)], pw=float(r.uniform(1.6, 2.2)))
    if name == "magnetised_spot":
        y = 5 * RHO + float(r.uniform(-3e-3, 3e-3)); return dict(xy=[5 * RHO + float(r.uniform(-3e-3, 3e-3)), y], w=float(r.uniform(2.2e-3, 4.5e-3)), a=[[float(r.normal(0, .02)) for _ in range(2)] for _ in range(4)], common=[float(r.normal(0, .02)) for _ in range(2)])
    if name == "beacon_turbulence": return dict(fc=[float(r.uniform(.15, .4)), float(r.uniform(2, 6))])
    if name == "electrode_contact": return dict(el=int(r.integers(4)), g=.002, on=float(r.uniform(8, 25)), offt=float(r.uniform(8, 25)))
    if name == "firmware_boundary": return dict(segs=S(), x0=[5 * RHO + float(r.uniform(-2.5, 2.5)) * RHO for _ in range(2)], a=[[float(r.normal(0, 1.5)), float(r.normal(0, 1.5))] for _ in range(4)])
    if name == "bandwidth_switch": return dict(v0=float(r.uniform(2.5e-2, 4e-2)), g=[float(r.normal(0, .015)) for _ in range(4)], psi=[float(r.normal(0, .015)) for _ in range(4)])
    if name == "sequential_sampling": return dict(dt=[sg(r) * float(r.uniform(2e-5, 8e-5)) for _ in range(4)])
    raise KeyError(name)

CAP = {"lateral_dependence": 8, "angle_dependence": 12, "thermal_drift": 12, "velocity_lag": 14, "psd_latency": 25, "hysteresis": 9, "gap_variation": 6, "axis_skew": 10, "adc_clipping": 9.5, "span_error": 12,
       "psd_misalignment": 12, "psd_nonlinearity": 15, "tooth_variation": 4, "extra_harmonics": 6, "quadrature_drift": 8}

# ------------------------------------------------------------------------------------------------ events of one recording
def courses(r, t, tc, n):
    """smooth wander of unit variance: random Fourier courses with an Ornstein-Uhlenbeck-like spectrum"""
    T = t[-1]; fr = np.abs(r.standard_cauchy((n, 24))) / (2 * np.pi * tc * T); fr = np.clip(fr, .25 / T, 6 / (tc * T)); a = r.normal(0, 1, (n, 24)); ph = r.uniform(0, 6.28, (n, 24))
    u = np.array([sum(a[k, j] * np.sin(2 * np.pi * fr[k, j] * t + ph[k, j]) for j in range(24)) for k in range(n)])
    return (u - u.mean(1, keepdims=True)) / u.std(1, keepdims=True)

def draw_temp(r, t, law):
    T = t[-1]; u = law["T0"] + law["warm"] * (1 - np.exp(-t / (law["tau"] * T))) + law["osc"] * np.sin(2 * np.pi * (t / T * law["cyc"] * r.uniform(.95, 1.05)) + law["ph"] + r.uniform(-.4, .4)) + r.normal(0, .05)
    return u

def draw_templaw(r, thermal):
    big = thermal or r.random() < .35
    return dict(T0=float(r.uniform(21, 27)), warm=float(r.uniform(2.5, 6) if big else r.uniform(0, .8)), tau=float(r.uniform(.2, .7)), osc=float(r.uniform(1.2, 2.8) if big else r.uniform(.1, .5)), cyc=float(r.uniform(1.3, 3.2)), ph=float(r.uniform(0, 6.28)))

def draw_events(r, plan, H, laws, templaw):
    E = {}; t = plan.t; n = plan.n; E["temp"] = draw_temp(r, t, templaw)
    seen = beacon_seen(plan, H)
    for nm, L in laws.items():
        if nm == "quadrature_drift": E[nm] = courses(r, t, L["tc"], 16).reshape(4, 4, n)
        elif nm == "beacon_vibration": E[nm] = [r.uniform(0, 6.28, len(L["f"])), courses(r, t, .1, len(L["f"]))]
        elif nm == "cycle_slip":
            pool = np.arange(int(.12 * n), int(.88 * n)); E[nm] = [int(r.choice(pool)) for _ in L["segs"]]
        elif nm == "outlier_bursts":
            idx = np.flatnonzero(seen) if L["target"] == "psd" else np.arange(n); m = np.zeros(n, bool); want = L["frac"] * len(idx); amp = np.zeros(n); dec = r.normal(0, 1, (n, 8))
            while m.sum() < want:
                k = int(r.integers(len(idx))); w = idx[k:k + int(r.integers(1, L["blen"] + 1))]; m[w] = True; amp[w] = np.exp(r.uniform(np.log(L["mult"][0]), np.log(L["mult"][1])))
            E[nm] = (m, amp, np.sign(dec) * (.85 + .15 * np.abs(np.tanh(dec))))
        elif nm == "mains_hum": E[nm] = r.uniform(0, 6.28, 2)
        elif nm == "sampling_jitter": E[nm] = r.normal(0, 1, (4, n))
        elif nm == "ambient_flicker": E[nm] = r.uniform(0, 6.28, 2)
        elif nm == "dark_offset_led_sag": E[nm] = r.uniform(0, 6.28, 2)
        elif nm == "beacon_bump":
            tb = t[seen]; E[nm] = [(float(np.quantile(tb, r.uniform(.2 + .4 * k, .4 + .4 * k) if L["n"] > 1 else r.uniform(.3, .7))), float(r.uniform(0, 6.28))) for k in range(L["n"])]
        elif nm == "loose_segment": E[nm] = [float(r.uniform(0, 6.28)), courses(r, t, .1, 1)[0]]
        elif nm == "beacon_turbulence":
            fr = np.exp(r.uniform(np.log(L["fc"][0]), np.log(L["fc"][1]), (2, 60))); a = r.normal(0, 1, (2, 60)) * (fr / L["fc"][0]) ** -.3; ph = r.uniform(0, 6.28, (2, 60))
            E[nm] = np.array([sum(a[k, j] * np.sin(2 * np.pi * fr[k, j] * t + ph[k, j]) for j in range(60)) / np.sqrt((a[k] ** 2).sum() / 2) for k in range(2)])
        elif nm == "electrode_contact":
            s = np.zeros(n); now = -r.uniform(0, 20); st = 0
            while now < t[-1]:
                d = r.exponential(L["on"] if st else L["offt"]); s[(t >= now) & (t < now + d)] = st; now += d; st = 1 - st
            E[nm] = s
    return E

def beacon_seen(plan, H):
    if not H["beacon"]: return np.zeros(plan.n, bool)
    c = deflection(plan.P0, H, 0.); run = plan.run
    near = (np.abs(c) < .0062).all(1); keep = np.array([not (q.startswith("flyby") or q == "scatter") for q in run])
    return near & keep

def deflection(P, H, b):
    d = P[:, :2] - np.array(H["o"]) - b; cx, sx = np.cos(P[:, 2]), np.sin(P[:, 2])
    return np.stack([cx * d[:, 0] + sx * d[:, 1] - H["lx"], -sx * d[:, 0] + cx * d[:, 1] - H["ly"]], 1)

# ------------------------------------------------------------------------------------------------ plant
SGN = np.array([1., 1., -1., -1.])                        # p_i = x or y + SGN * (l_s/2) theta
_fields = {}
def tooth_field(L):
    if L["seed"] not in _fields:
        r = np.random.default_rng(L["seed"]); n = 110; A = r.normal(0, 1, (2, n, n)); lines = np.stack([np.repeat(r.normal(0, 1, (n, 1)), n, 1), np.repeat(r.normal(0, 1, (1, n)), n, 0)])
        if len(_fields) > 4: _fields.clear()
        _fields[L["seed"]] = A * math.sqrt(1 - L["mix"] ** 2) + L["mix"] * lines
    return _fields[L["seed"]]
def footprint(L, axis, X, Y):
    """mean displacement of the teeth under a segment at X, Y: raised-cosine footprint of n_own by n_lat teeth"""
    A = tooth_field(L)[axis]; wx, wy = (L["n_own"], L["n_lat"]) if axis == 0 else (L["n_lat"], L["n_own"]); o = 50
    def ker(u, w):
        k0 = np.floor(u).astype(int) - w // 2 - 1; k = k0[:, None] + np.arange(w + 3)[None]; d = (k - u[:, None]) / (w / 2 + .5); g = np.where(np.abs(d) < 1, .5 + .5 * np.cos(np.pi * d), 0.); return k + o, g / g.sum(1, keepdims=True)
    kx, gx = ker(X / RHO, wx); ky, gy = ker(Y / RHO, wy); kx = np.clip(kx, 0, 109); ky = np.clip(ky, 0, 109)
    return np.einsum("na,nab,nb->n", gx, A[kx[:, :, None], ky[:, None, :]], gy)

def gap_map(L, X, Y):
    r = np.random.default_rng(L["seed"]); g = np.zeros_like(X); 
    for k in range(7):
        lam = r.uniform(L["lmin"], 3 * L["lmin"]); a = r.uniform(0, 2 * np.pi); g = g + r.uniform(.5, 1) * np.sin(2 * np.pi / lam * (X * math.cos(a) + Y * math.sin(a)) + r.uniform(0, 6.28))
    g = g / math.sqrt(7 * .29) ; tx, ty = r.normal(0, .5, 2) / .02
    return L["rms"] * np.tanh((g + tx * (X - 5e-3) + ty * (Y - 5e-3)) / 2) * 2

def dahl(p, sigma):
    z = np.empty(len(p)); q = 0.; last = p[0]; ex = math.exp
    for k, v in enumerate(p.tolist()):
        d = v - last; s = 1. if d > 0 else -1.; 
        if d: q = s - (s - q) * ex(-abs(d) / sigma)
        last = v; z[k] = q
    return z
def play(p, r):
    z = np.empty(len(p)); q = float(p[0])
    for k, v in enumerate(p.tolist()):
        if q < v - r: q = v - r
        elif q > v + r: q = v + r
        z[k] = (v - q) / r
    return z

class Plant:
    def __init__(s, H, plan, laws, scale, ev):
        s.H, s.plan, s.L, s.k, s.ev, s.n = H, plan, laws, scale, ev, plan.n
        s.nseg = 1 if H["form"] == "reference" else 4
        s.time_err = [np.zeros(s.n) for _ in range(4)]; t = plan.t; V = plan.V
        s.vseg = [V[:, 0] + SGN[0] * H["ls"] / 2 * V[:, 2], V[:, 1] + H["ls"] / 2 * V[:, 2], V[:, 0] - H["ls"] / 2 * V[:, 2], V[:, 1] - H["ls"] / 2 * V[:, 2]]
        s.seen = beacon_seen(plan, H)
        if "thermal_drift" in laws:
            L = laws["thermal_drift"]; k = scale["thermal_drift"]; T = ev["temp"]; s.dT = T - T[0]
            if L["lag_s"]:
                tt = np.arange(0, t[-1] + 1, .25); Ti = np.interp(tt, t, s.dT); y = np.empty_like(Ti); q = Ti[0]; a = 1 - math.exp(-.25 / L["lag_s"])
                for j, v in enumerate(Ti.tolist()): q += a * (v - q); y[j] = q
                s.dT = np.interp(t, tt, y)
            for i in range(4): s.time_err[i] = s.time_err[i] + k * L["c"][i] * UM * s.dT
        if "hysteresis" in laws:
            L = laws["hysteresis"]; k = scale["hysteresis"]
            for i in range(s.nseg):
                p = s.geom(i, plan.P0)[0]
                z = dahl(p, L["sigma"][0]) if L["kind"] == "dahl" else L["w"] * dahl(p, L["sigma"][0]) + (1 - L["w"]) * dahl(p, L["sigma"][1]) if L["kind"] == "dahl2" else sum(play(p, q) for q in L["thr"]) / len(L["thr"])
                s.time_err[i] = s.time_err[i] - k * L["b"][i] * UM * z
        if "bearing_lift" in laws:
            L = laws["bearing_lift"]; k = scale["bearing_lift"]; sp = np.hypot(V[:, 0], V[:, 1])
            for i in range(4): s.time_err[i] = s.time_err[i] + k * L["k"][i] * UM * (sp / .03) ** L["pw"]
        if "loose_segment" in laws:
            L = laws["loose_segment"]; k = scale["loose_segment"]; i = L["seg"]; e = ev["loose_segment"]
            s.time_err[i] = s.time_err[i] + k * UM * (1 + L["am"] * e[1]) * np.sin(2 * np.pi * L["f"] * t + e[0])

    def geom(s, i, P):
        """what tooth position segment i stands over, its place on the platen (X, Y), its tooth phase across"""
        H = s.H; x, y, th = P.T; a = 0.; lo = H["lo"]
        if "span_error" in s.L: L = s.L["span_error"]; a = s.k["span_error"] * L["a"][i]; lo = lo + s.k["span_error"] * L["lo"]
        arm = SGN[i] * (H["ls"] / 2 + a) * th; ox = [-lo, H["ls"] / 2, lo, -H["ls"] / 2][i]; oy = [-H["ls"] / 2, -lo, H["ls"] / 2, lo][i]
        p = (x if i in (0, 2) else y) + arm; X = x + ox; Y = y + oy
        lat = [y - lo * th, x + lo * th, y + lo * th, x - lo * th][i]
        if "axis_skew" in s.L:
            L = s.L["axis_skew"]; k = s.k["axis_skew"]
            p = p * (1 + L["common"] + k * L["eps"] * (.5 if i in (0, 2) else -.5)) + (k * L["sq"] * X if i in (1, 3) else 0.)
        return p, X, Y, lat

    def tooth_pos(s, i, P):
        L = s.L; k = s.k; p, X, Y, lat = s.geom(i, P); e = s.time_err[i].copy(); am = 0.
        if "lateral_dependence" in L and str(i) in L["lateral_dependence"]["seg"]:
            a1, f1, a2, f2, pk = L["lateral_dependence"]["seg"][str(i)]; u = F * lat + f1
            e += k["lateral_dependence"] * UM * (a1 * np.sin(u) / (1 - pk * .4 * np.cos(u)) + a2 * np.sin(2 * F * lat + f2)); am = L["lateral_dependence"]["am"] * np.sin(u + 1)
        if "tooth_variation" in L: q = L["tooth_variation"]; e += k["tooth_variation"] * q["rms_um"] * UM * footprint(q, 0 if i in (0, 2) else 1, X, Y)
        if "thermal_drift" in L: e += L["thermal_drift"]["alpha"] * s.dT * (p - 5e-3)
        if "gap_variation" in L: e += k["gap_variation"] * L["gap_variation"]["k"][i] * gap_map(L["gap_variation"], X, Y)
        return p + e, X, Y, am

    def coils(s, i, dt):
        """sine and cosine of segment i in counts, before noise, at the sample times + dt"""
        H, L, K = s.H, s.L, s.k; P = s.plan.P0 if np.ndim(dt) == 0 and dt == 0 else s.plan.pose(dt); th = P[:, 2]; t = s.plan.t + dt
        p, X, Y, am = s.tooth_pos(i, P); ph = F * (p + H["mount"][i]); A = H["A"][i] * (1 + am); g = H["g"][i]; ps = H["psi"][i]; os, oc = (np.full(s.n, H["off"][i][j] * H["A"][i]) for j in (0, 1))
        ss = np.zeros(s.n); cc = np.zeros(s.n); ds = dc = 0.; fs = fc = 1.; h3 = H["h3"][i]; ra = r3 = 1.
        if "gap_variation" in L:
            q = L["gap_variation"]; d = gap_map(q, X, Y); ra = np.exp(-2 * np.pi * d / RHO); r3 = np.exp(-4 * np.pi * d / RHO); kk = K["gap_variation"]
            ss = ss + kk * r3 * (q["h3"][i][0] * np.sin(3 * ph) + q["h3"][i][1] * np.cos(3 * ph)); cc = cc + kk * r3 * (q["h3"][i][2] * np.cos(3 * ph) + q["h3"][i][3] * np.sin(3 * ph))
        if "angle_dependence" in L and str(i) in L["angle_dependence"]["seg"]:
            dy, ks, kc, w1, w2 = L["angle_dependence"]["seg"][str(i)]; kk = K["angle_dependence"]
            ds, dc = F * kk * dy * th, -F * kk * dy * th; fs = np.sinc(F * kk ** .5 * w1 * th / np.pi / 2); fc = np.sinc(F * kk ** .5 * w2 * th / np.pi / 2); os = os + kk * ks * th * A; oc = oc + kk * kc * th * A
        if "extra_harmonics" in L and str(i) in L["extra_harmonics"]["seg"]:
            q = L["extra_harmonics"]; kk = K["extra_harmonics"]
            for m, (a, b, c, d) in zip(q["orders"], q["seg"][str(i)]): ss = ss + kk * (a * np.sin(m * ph) + b * np.cos(m * ph)); cc = cc + kk * (c * np.cos(m * ph) + d * np.sin(m * ph))
        gs, gc, p1, p2 = 1 + g / 2, 1 - g / 2, ps / 2, -ps / 2
        if "quadrature_drift" in L and str(i) in L["quadrature_drift"]["seg"]:
            q = L["quadrature_drift"]["seg"][str(i)]; kk = K["quadrature_drift"]; u = s.ev["quadrature_drift"][i]
            os = os + kk * q["os"] * u[0] * A; oc = oc + kk * q["oc"] * u[1] * A; gs = gs + kk * q["g"] * u[2] / 2; gc = gc - kk * q["g"] * u[2] / 2; p1 = p1 + kk * q["psi"] * u[3] / 2; p2 = p2 - kk * q["psi"] * u[3] / 2
        if "bandwidth_switch" in L:
            q = L["bandwidth_switch"]; kk = K["bandwidth_switch"]; on = np.abs(s.vseg[i]) > q["v0"]
            gs = gs + kk * q["g"][i] / 2 * on; gc = gc - kk * q["g"][i] / 2 * on; p1 = p1 + kk * q["psi"][i] / 2 * on; p2 = p2 - kk * q["psi"][i] / 2 * on
        if "magnetised_spot" in L:
            q = L["magnetised_spot"]; kk = K["magnetised_spot"]; b = kk / (1 + ((X - q["xy"][0]) ** 2 + (Y - q["xy"][1]) ** 2) / q["w"] ** 2) ** 1.5 * A; os = os + (q["a"][i][0] + q["common"][0]) * b; oc = oc + (q["a"][i][1] + q["common"][1]) * b
        S = A * ra * (gs * fs * np.sin(ph + p1 + ds) + h3 * np.sin(3 * ph) + ss) + os
        C = A * ra * (gc * fc * np.cos(ph + p2 + dc) - h3 * np.cos(3 * ph) + cc) + oc
        return S, C

    def filtered(s, i):
        L = s.L; base = 0.
        if "sampling_jitter" in L: base = s.k["sampling_jitter"] * L["sampling_jitter"]["sigma"][i] * s.ev["sampling_jitter"][i]
        if "sequential_sampling" in L:
            d = s.k["sequential_sampling"] * L["sequential_sampling"]["dt"][i]; return s.coils(i, -d / 2)[0], s.coils(i, d / 2)[1]
        if "velocity_lag" in L:                            # first-order filter by Gauss-Laguerre quadrature over its own past; eddy share follows slower
            q = L["velocity_lag"]; tau = s.k["velocity_lag"] * q["tau"][i]; x, w = np.polynomial.laguerre.laggauss(4); S = C = 0.
            for xx, ww in zip(x, w):
                a, b = s.coils(i, base - tau * xx); S = S + ww * a; C = C + ww * b
            if q["eddy"][i] > .25:                        # an eddy-current path: a small part of the flux is late by a longer time
                a, b = s.coils(i, base - 4 * tau); e = .15 * q["eddy"][i]; S = (1 - e) * S + e * a; C = (1 - e) * C + e * b
            return S, C
        return s.coils(i, base)

    def quad(s, r):
        """counts of all segments; r None: noise-free, unrounded"""
        H, L, K = s.H, s.L, s.k; out = [list(s.filtered(i)) for i in range(s.nseg)]
        if "mux_crosstalk" in L:
            q = L["mux_crosstalk"]; j = q["frm"]; i = q["to"]; k = K["mux_crosstalk"]; out[i] = [out[i][0] + k * q["eps"][0] * out[j][0], out[i][1] + k * q["eps"][1] * out[j][1] ]
        if "mains_hum" in L:
            q = L["mains_hum"]; i = q["seg"]; u = 2 * np.pi * q["f"] * s.plan.t + s.ev["mains_hum"][0]; w = np.sin(u) + q["h3"] * np.sin(3 * u + s.ev["mains_hum"][1])
            for j in (0, 1): out[i][j] = out[i][j] + K["mains_hum"] * q["a"][j] * H["A"][i] * w
        if "adc_clipping" in L and L["adc_clipping"]["kind"] == "range":   # the pair's gain is set too high for the converter
            for key, (u1, u2, ch) in L["adc_clipping"]["seg"].items():
                i = int(key); f = 32767 / ((1 - .04 * K["adc_clipping"] * u1) * H["A"][i]); out[i] = [out[i][0] * f, out[i][1] * f]
        if r is not None:
            pos = H["form"] == "positions"
            for i in range(s.nseg):
                for j in (0, 1):
                    nz = 0. if pos else H["noise"]; f = 1.
                    if "excess_noise" in L and L["excess_noise"]["target"] == "quad" and i in L["excess_noise"]["segs"]: f = L["excess_noise"]["k"]
                    out[i][j] = out[i][j] + f * nz * r.normal(0, 1, s.n)
                    if not pos and "outlier_bursts" in L and L["outlier_bursts"]["target"] == "quad" and i in L["outlier_bursts"]["segs"]:
                        m, a, sgn = s.ev["outlier_bursts"]; out[i][j] = out[i][j] + m * a * nz * sgn[:, 2 * i + j]
        if "adc_clipping" in L:
            q = L["adc_clipping"]; k = K["adc_clipping"]
            for key, (u1, u2, ch) in q["seg"].items():
                i = int(key)
                for j in (0, 1):
                    if q["kind"] != "range" and ch != "both" and ch != "sc"[j]: continue
                    lv = 1 - .04 * k * (u1 if j == 0 else u2); A = H["A"][i]; v = out[i][j]
                    if q["kind"] == "soft": lim = lv * 1.06 * A; out[i][j] = v / (1 + np.abs(v / lim) ** q["knee"]) ** (1 / q["knee"])
                    elif q["kind"] == "hard": out[i][j] = np.clip(v, -lv * A, lv * A)
                    else: out[i][j] = np.clip(v, -32768, 32767)
        return out

    def psd(s, r):
        H, L, K = s.H, s.L, s.k; t = s.plan.t; b = np.zeros((s.n, 2)); P = s.plan.P0; h = H["h"]
        if "beacon_vibration" in L:
            q = L["beacon_vibration"]; e = s.ev["beacon_vibration"]
            for j, (f, a, d) in enumerate(zip(q["f"], q["a"], q["dir"])):
                w = K["beacon_vibration"] * UM * a * (1 + q["am"] * .5 * np.tanh(e[1][j])) * np.sin(2 * np.pi * f * t + e[0][j]); b += w[:, None] * np.array([math.cos(d), math.sin(d)])
        if "thermal_drift" in L:
            q = L["thermal_drift"]; b += K["thermal_drift"] * UM * s.dT[:, None] * np.array(q["psd"]); h = h * (1 + min(K["thermal_drift"], 3) * q["h"] * s.dT)
        if "beacon_relaxation" in L:
            q = L["beacon_relaxation"]; w = q["w"] * np.exp(-t / q["tau"][0]) + (1 - q["w"]) * np.exp(-t / q["tau"][1]); b += K["beacon_relaxation"] * UM * w[:, None] * np.array(q["a"])
        if "beacon_bump" in L:
            for (tb, d), z in zip(s.ev["beacon_bump"], L["beacon_bump"]["size"]): b += K["beacon_bump"] * UM * z * (t > tb)[:, None] * np.array([math.cos(d), math.sin(d)])
        if "beacon_turbulence" in L: b += K["beacon_turbulence"] * UM * s.ev["beacon_turbulence"].T
        if "courier_tilt" in L:
            for kx, ky, ph, ax, ay in L["courier_tilt"]["k"]: b += K["courier_tilt"] * UM * np.sin(kx * P[:, 0] + ky * P[:, 1] + ph)[:, None] * np.array([ax, ay])
        if "psd_latency" in L:
            q = L["psd_latency"]; tau = K["psd_latency"] * q["tau"]      # part a pure shift, part a filter's tail (late) or lead (early)
            x, w = np.polynomial.laguerre.laggauss(3); c = 0.
            for xx, ww in zip(x, w): c = c + ww * deflection(s.plan.pose(-tau * ((1 - q["filt"]) + q["filt"] * xx)), H, b)
        else: c = deflection(P, H, b)
        if "glint" in L:
            q = L["glint"]; w = np.exp(-.5 * (((c - np.array(q["c"])) / np.array(q["w"])) ** 2)); c = c + K["glint"] * UM * np.array(q["a"]) * (w[:, :1] * .5 + w * .5)
        if "etalon_fringes" in L:
            q = L["etalon_fringes"]; u = 2 * np.pi * c / np.array(q["lam"]) + np.array(q["ph"]); c = c + K["etalon_fringes"] * UM * np.array(q["a"]) * np.sin(u) / (1 - q["fin"] * np.cos(u))
        d = c / np.reshape(h, (-1, 1)) / H["tfs"]
        if "psd_misalignment" in L:
            q = L["psd_misalignment"]; k = K["psd_misalignment"]; a = k * q["rot"]; x, y = d.T
            d = np.stack([(1 + k * q["gain"] / 2) * (math.cos(a) * x - math.sin(a) * y), (1 - k * q["gain"] / 2) * (math.sin(a) * x + math.cos(a) * y)], 1)
        if "psd_nonlinearity" in L:
            q = L["psd_nonlinearity"]; k = K["psd_nonlinearity"]; x, y = d.T; rr = x * x + y * y; sat = 1 / (1 + q["sat"] * rr)
            d = np.stack([x + k * sat * (q["k3"][0] * x ** 3 + q["k2"][0] * x * x + q["kx"][0] * x * y + q["pin"] * x * rr), y + k * sat * (q["k3"][1] * y ** 3 + q["k2"][1] * y * y + q["kx"][1] * x * y + q["pin"] * y * rr)], 1)
        S = np.full(s.n, H["S"])
        if "dark_offset_led_sag" in L:
            q = L["dark_offset_led_sag"]; S = S * (1 - q["sag"] * (1 - np.exp(-t / (q["tau"] * t[-1]))) + q["cyc"] * (np.sin(2 * np.pi * t / t[-1] * 2.3 + s.ev["dark_offset_led_sag"][0]) - 1) / 2)
        el = [S / 2 * (1 + d[:, 0]), S / 2 * (1 - d[:, 0]), S / 2 * (1 + d[:, 1]), S / 2 * (1 - d[:, 1])]
        if "ambient_flicker" in L:
            q = L["ambient_flicker"]; u = 2 * np.pi * q["f"] * t + s.ev["ambient_flicker"][0]; w = K["ambient_flicker"] * q["m"] * H["S"] * (1 + np.sin(u) + q["even"] * np.sin(2 * u + s.ev["ambient_flicker"][1])); el = [e + w / 2 for e in el]
        if "dark_offset_led_sag" in L:
            q = L["dark_offset_led_sag"]; k = K["dark_offset_led_sag"]; el[0] = el[0] + k * q["o"][0]; el[2] = el[2] + k * q["o"][1]
        if "electrode_contact" in L:
            q = L["electrode_contact"]; el[q["el"]] = el[q["el"]] * (1 - K["electrode_contact"] * q["g"] * s.ev["electrode_contact"])
        if r is not None:
            f = L["excess_noise"]["k"] if "excess_noise" in L and L["excess_noise"]["target"] == "psd" else 1.
            el = [e + f * H["psd_noise"] * r.normal(0, 1, s.n) for e in el]
            if "outlier_bursts" in L and L["outlier_bursts"]["target"] == "psd":
                m, a, sgn = s.ev["outlier_bursts"]; el = [e + m * a * H["psd_noise"] * sgn[:, j] for j, e in enumerate(el)]
            el = [np.clip(np.rint(e), 1, 32767) for e in el]
        return [np.where(s.seen, e, 0.) for e in el]

    def record(s, r):
        """r None: noise-free and unrounded, for scaling"""
        H, L = s.H, s.L; R = {}; q = s.quad(r); slip = [np.zeros(s.n, int) for _ in range(4)]
        if "cycle_slip" in L:
            for i, t, k in zip(L["cycle_slip"]["segs"], L["cycle_slip"]["teeth"], s.ev["cycle_slip"]): slip[i][k:] += t
        R["pbar"] = []
        for i in range(s.nseg):
            S, C = q[i]
            if r is not None and H["form"] != "positions": S = np.clip(np.rint(S) + 0., -32768, 32767); C = np.clip(np.rint(C) + 0., -32768, 32767)
            fr = np.arctan2(S, C) / (2 * np.pi); want = s.tooth_pos(i, s.plan.P0)[0] + H["mount"][i]
            n = np.rint(want / RHO - fr).astype(int) + slip[i]; p = (n + fr) * RHO
            if "firmware_boundary" in L and i in L["firmware_boundary"]["segs"]:
                w = L["firmware_boundary"]; ph = 2 * np.pi * fr; out = n >= round(w["x0"][i % 2] / RHO); e = s.k["firmware_boundary"] * UM * out * (w["a"][i][0] * np.sin(2 * ph) + w["a"][i][1] * np.cos(2 * ph)); p = p + e
                if H["form"] != "positions":              # counts are logged after the firmware's correction: the vector is turned
                    A = np.hypot(S, C); a = F * e + np.arctan2(S, C); S, C = A * np.sin(a), A * np.cos(a)
                    if r is not None: S = np.clip(np.rint(S) + 0., -32768, 32767); C = np.clip(np.rint(C) + 0., -32768, 32767)
                    fr = np.arctan2(S, C) / (2 * np.pi); n = np.rint((want + e) / RHO - fr).astype(int) + slip[i]; p = (n + fr) * RHO
            if r is not None and H["form"] == "positions":
                f = L["excess_noise"]["k"] if "excess_noise" in L and L["excess_noise"]["target"] == "quad" and i in L["excess_noise"]["segs"] else 1.
                p = p + f * H["pos_noise"] * r.normal(0, 1, s.n)
                if "outlier_bursts" in L and L["outlier_bursts"]["target"] == "quad" and i in L["outlier_bursts"]["segs"]: m, a, sgn = s.ev["outlier_bursts"]; p = p + m * a * H["pos_noise"] * sgn[:, 2 * i]
            R[f"q{i+1}s"], R[f"q{i+1}c"], R[f"n{i+1}"] = S, C, n; R["pbar"].append(p)
        if H["beacon"]: R["psd"] = s.psd(r)
        if s.nseg == 1: R["ref"] = s.plan.P0[:, 0] + (0 if r is None else r.normal(0, 20e-9, s.n)); 
        return R

# ------------------------------------------------------------------------------------------------ my own baseline: (3), (5), (11), Gauss-Newton
ORD = (1, 2, 4, 6)
def gam(p): return np.stack([np.ones_like(p)] + [g(m * F * p) for m in ORD for g in (np.sin, np.cos)], 1)
def baseline(R, H, weights, thin=1):
    """residual of each channel after least squares; returns dict of arrays (m)"""
    pb = R["pbar"]
    if len(pb) == 1:
        G = gam(pb[0]); y = R["ref"] - pb[0]; k = np.linalg.lstsq(G, y, rcond=None)[0]; return {"segment_1": y - G @ k}
    G = [gam(p) for p in pb]; ls = H["ls"]; k = np.zeros((4, 9))
    if not H["beacon"]:
        M = np.concatenate([G[0], -G[2][:, 1:], -G[1][:, 1:], G[3][:, 1:]], 1); y = -(pb[0] - pb[2] - pb[1] + pb[3]); x = np.linalg.lstsq(M, y, rcond=None)[0]; return {"g_p": M @ x - y}
    el = R["psd"]; ix = np.flatnonzero(el[0] + el[1] > 0); tx = H["tfs"] * (el[0][ix] - el[1][ix]) / (el[0][ix] + el[1][ix]); ty = H["tfs"] * (el[2][ix] - el[3][ix]) / (el[2][ix] + el[3][ix])
    h, lx, ly = H["h_nom"], H["lx_nom"], H["ly_nom"]; sp, sx, sy = weights
    pm = [p[ix].mean() for p in pb]; ox = (pm[0] + pm[2]) / 2 - lx; oy = (pm[1] + pm[3]) / 2 - ly
    sgn = [1, -1, -1, 1]; st = [1, 1, -1, -1]; Gi = [g[ix] for g in G]
    for it in range(4):
        ph = [p + g @ q for p, g, q in zip(pb, G, k)]; b = [p[ix] for p in ph]; th = (b[0] - b[2] + b[1] - b[3]) / (2 * ls); c, s = np.cos(th), np.sin(th); cx, cy = h * tx, h * ty
        gp = ph[0] - ph[2] - ph[1] + ph[3]
        gx = -(b[0] + b[2]) / 2 + c * cx - s * cy - ly * s + lx * c + ox; gy = -(b[1] + b[3]) / 2 + s * cx + c * cy + ly * c + lx * s + oy
        if it == 3: break
        dx = -s * (cx + lx) - c * (cy + ly); dy = c * (cx + lx) - s * (cy + ly); z = np.zeros((len(ix), 0))
        Jp = np.concatenate([a * g for a, g in zip(sgn, G)] + [np.zeros((len(gp), 5))], 1)
        ext = lambda *v: np.stack(v, 1); o = np.ones_like(c); ze = 0 * c
        Jx = np.concatenate([(-.5 if i in (0, 2) else 0.) * Gi[i] + (st[i] / (2 * ls) * dx)[:, None] * Gi[i] for i in range(4)] + [ext(c * tx - s * ty, c, -s, o, ze)], 1)
        Jy = np.concatenate([(-.5 if i in (1, 3) else 0.) * Gi[i] + (st[i] / (2 * ls) * dy)[:, None] * Gi[i] for i in range(4)] + [ext(s * tx + c * ty, s, c, ze, o)], 1)
        J = np.concatenate([Jp / sp, Jx / sx, Jy / sy]); y = np.concatenate([gp / sp, gx / sx, gy / sy]); sc = np.sqrt((J * J).sum(0)); J = J / sc
        N = J.T @ J; lam, U = np.linalg.eigh(N); lam = np.where(lam > 1e-12 * lam[-1], lam, np.inf); d = -(U @ ((U.T @ (J.T @ y)) / lam)) / sc
        k = k + d[:36].reshape(4, 9); h += d[36]; lx += d[37]; ly += d[38]; ox += d[39]; oy += d[40]
    return {"g_p": gp, "g_x": gx, "g_y": gy}
def rms(R, H, W): return {c: float(np.sqrt(np.mean((v - v.mean()) ** 2))) for c, v in baseline(R, H, W).items()}
def noise_sd(H):
    s = H["pos_noise"] if H["form"] == "positions" else RHO / (2 * np.pi) * H["noise"] / H["A0"]; cn = H["h"] * H["tfs"] * math.sqrt(2 * (H["psd_noise"] ** 2 + 1 / 12)) / H["S"]; th = s / H["ls"]
    return (2 * s, math.sqrt(s * s / 2 + cn * cn + (H["ly"] * th) ** 2), math.sqrt(s * s / 2 + cn * cn + (H["lx"] * th) ** 2))
def excess(a, b): return {c: math.sqrt(max(a[c] ** 2 - b[c] ** 2, 0.)) for c in a}

# ------------------------------------------------------------------------------------------------ a case
def scale_effect(r, name, H, plan, law, ev, plain, W):
    """scale so that the chosen channel's excess is the drawn size; None if the cap forbids"""
    PSD = name in ("psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew") or (name in UNLISTED and not set("nr") & set(UNLISTED[name][2]) and name != "loose_segment")
    if H["beacon"] and not PSD and r.random() < .5: mode, target = "g_p", lu(r, .75, 2.2)
    elif H["beacon"] and not PSD: mode, target = "max", lu(r, 1.5, 3.9)
    else: mode, target = "max", lu(r, .8, 3.7)
    def val(e): return max(e.values()) if mode == "max" else max(e["g_p"], max(e.values()) * target / (4 * UM) * UM)   # no channel past 4 um
    def f(k): return excess(rms(Plant(H, plan, {name: law}, {name: k}, ev).record(None), H, W), plain)
    k = 1.; hist = []; cap = CAP.get(name, 60)
    for it in range(9):
        e = f(k); v = val(e) / UM; hist.append((math.log(k), math.log(max(v, 1e-4))))
        if mode == "g_p" and it == 0 and e["g_p"] < .25 * max(e.values()): mode = "max"; target = lu(r, 1., 3.8); v = val(e) / UM; hist = [(math.log(k), math.log(max(v, 1e-4)))]
        if abs(v / target - 1) < .05: break
        sl = 1.
        if len(hist) > 1 and abs(hist[-1][0] - hist[-2][0]) > 1e-3: sl = min(max((hist[-1][1] - hist[-2][1]) / (hist[-1][0] - hist[-2][0]), .6), 4.)
        k2 = k * math.exp(np.clip((math.log(target) - hist[-1][1]) / sl, -2.5, 2.5)); k = min(k2, cap)
        if len(hist) > 3 and k == cap and hist[-1][0] == math.log(cap): return None
    if max(e.values()) < .72 * UM or abs(v / target - 1) > .3: return None
    return k, {c: round(x / UM, 3) for c, x in e.items()}, mode

def clean(o):
    if isinstance(o, dict): return {str(k): clean(v) for k, v in o.items()}
    if isinstance(o, (list, tuple)): return [clean(v) for v in o]
    if isinstance(o, (bool, np.bool_)): return bool(o)
    if isinstance(o, (int, np.integer)): return int(o)
    if isinstance(o, (float, np.floating)): return float(f"{float(o):.6g}")
    return o

def fmt_cols(cols, n):
    out = []
    for name, v, f in cols: out.append([f % x for x in v.tolist()] if f else v)
    return out

def write(d, H, plan, ev, R, give_temp, dev, r):
    os.makedirs(d, exist_ok=True); ref = H["form"] == "reference"; pos = H["form"] == "positions"; ns = 1 if ref else 4
    t = ['schema = 1', f'device = "{dev}"', 'source = "simulator b: plant by other hands"', '', '[geometry]', f'pitch_m = {RHO}', f'span_m = {H["ls"]}', f'lateral_m = {H["lo"]:.4f}', '']
    if H["beacon"]: t += ['[coordination]', f'height_m = {H["h_nom"]}', f'lever_x_m = {H["lx_nom"]}', f'lever_y_m = {H["ly_nom"]}', f'tan_full_scale = {H["tfs"]}', '']
    t += ['[electronics]'] + ([f'position_noise_m = {H["pos_noise"]:.4g}'] if pos else ['adc_bits = 16', f'amplitude_counts = {int(H["A0"])}', f'quadrature_noise_counts = {H["noise"]}'])
    if H["beacon"]: t += [f'psd_sum_counts = {int(H["S0"])}', f'psd_noise_counts = {H["psd_noise"]}']
    open(os.path.join(d, "recording.toml"), "w").write("\n".join(t) + "\n")
    C = [("t_s", plan.t, "%.6f"), ("run", plan.run.tolist(), None)]
    for i in range(ns):
        if pos: C.append((f"p{i+1}_m", R["pbar"][i], "%.9f"))
        else: C += [(f"q{i+1}s", R[f"q{i+1}s"], "%d"), (f"q{i+1}c", R[f"q{i+1}c"], "%d"), (f"n{i+1}", R[f"n{i+1}"], "%d")]
    if H["beacon"]: C += [(n, e, "%d") for n, e in zip(("psd_xp", "psd_xn", "psd_yp", "psd_yn"), R["psd"])]
    if give_temp: C.append(("temp_c", ev["temp"] + r.normal(0, .02, plan.n), "%.2f"))
    C.append(("cmd_x_m", plan.cmd[:, 0], "%.7f"))
    if not ref: C += [("cmd_y_m", plan.cmd[:, 1], "%.7f"), ("cmd_theta_rad", plan.cmd[:, 2], "%.8f")]
    if ref: C.append(("ref_x_m", R["ref"], "%.9f"))
    assert (np.diff(np.round(plan.t, 6)) > 0).all()
    rows = zip(*fmt_cols(C, plan.n))
    with open(os.path.join(d, "samples.csv"), "w") as fh: fh.write(",".join(c[0] for c in C) + "\n"); fh.write("\n".join(map(",".join, rows)) + "\n")

def allowed_forms(names):
    f = []
    for form, ch in (("beacon", "b"), ("no_beacon", "n"), ("positions", "p"), ("reference", "r")):
        ok = True
        for nm in names:
            if nm in UNLISTED: ok &= ch in UNLISTED[nm][2]
            elif form == "no_beacon": ok &= nm not in NEED_BEACON
            elif form == "positions": ok &= nm not in NOT_POSITIONS
            elif form == "reference": ok &= nm not in NOT_REFERENCE
        if ok: f.append(form)
    return f

def one_case(seed, kind, names, out, cid):
    for attempt in range(40):
        r = np.random.default_rng([seed, attempt]); al = allowed_forms(names); wt = np.array([{"beacon": .66, "no_beacon": .22, "positions": .115, "reference": .10}[f] for f in al])
        if attempt == 0 or attempt % 10 == 0: form = str(r.choice(al, p=wt / wt.sum()))
        H = draw_hw(r, form, names); mlaw = draw_motion(r, H, names); plan = draw_plan(np.random.default_rng([seed, attempt, 11]), H, mlaw, False); W = noise_sd(H)
        if not 3000 <= plan.n <= 12000: continue
        tl = draw_templaw(r, "thermal_drift" in names); laws = {n: draw_law(r, n, H, form) for n in names}
        ev = draw_events(np.random.default_rng([seed, attempt, 12]), plan, H, laws, tl); plain = rms(Plant(H, plan, {}, {}, ev).record(None), H, W)
        if max(plain.values()) > .5 * UM or plain.get("g_p", 0) > .08 * UM: continue
        scale = {n: 1. for n in names}; info = {}; ok = True; nr = lambda k: np.random.default_rng([seed, attempt, k])
        clean_noisy = rms(Plant(H, plan, {}, {}, ev).record(nr(21)), H, W)
        for nm in names:
            if nm in UNSCALED:
                e = excess(rms(Plant(H, plan, {nm: laws[nm]}, {nm: 1.}, ev).record(nr(21)), H, W), clean_noisy); e = {c: x / UM for c, x in e.items()}; info[nm] = {"excess_um": e, "scaled_on": "none"}
                if max(e.values()) < .72 or (nm != "cycle_slip" and max(e.values()) > 8) : ok = False; break
            else:
                for tr in range(6):
                    q = scale_effect(r, nm, H, plan, laws[nm], ev, plain, W)
                    if q: break
                    laws[nm] = draw_law(r, nm, H, form); ev[nm] = draw_events(np.random.default_rng([seed, attempt, 12, tr]), plan, H, {nm: laws[nm]}, tl).get(nm)
                if not q: ok = False; break
                scale[nm] = q[0]; info[nm] = {"scale": q[0], "excess_um": q[1], "scaled_on": q[2]}
        if not ok: continue
        for e2 in range(8):                                 # second recording: same hardware, events drawn anew; the effect must show there too
            plan2 = draw_plan(np.random.default_rng([seed, attempt, 31, e2]), H, mlaw, True); ev2 = draw_events(np.random.default_rng([seed, attempt, 32, e2]), plan2, H, laws, tl); p2 = rms(Plant(H, plan2, {}, {}, ev2).record(None), H, W); good = True
            if not 3000 <= plan2.n <= 12000: continue
            for nm in names:
                if nm in UNSCALED: continue
                x = excess(rms(Plant(H, plan2, {nm: laws[nm]}, {nm: scale[nm]}, ev2).record(None), H, W), p2); info[nm]["excess_second_um"] = {c: v / UM for c, v in x.items()}; good &= .55 * UM < max(x.values()) < 5 * UM
            if good: break
        else: continue
        if form != "positions" and not {"adc_clipping", "outlier_bursts"} & set(names):      # nothing but a drawn clipping may reach the converter's end
            top = max(np.abs(np.array(x)).max() for pl, e in ((plan, ev), (plan2, ev2)) for x in Plant(H, pl, laws, scale, e).quad(None))
            if top > 32000: continue
        give_temp = bool(r.random() < .9) or "thermal_drift" in names; dev = f"courier b-{seed % 10000:04d}"; summ = {}
        for which, pl, e, k in (("first", plan, ev, 41), ("second", plan2, ev2, 51)):
            R = Plant(H, pl, laws, scale, e).record(nr(k)); write(os.path.join(out, cid, which), H, pl, e, R, give_temp, dev, nr(k + 1))
            summ[which] = {"samples": pl.n, "rms_um": {c: v / UM for c, v in rms(R, H, W).items()}}
        law = {"effects": {n: {**{k: v for k, v in laws[n].items()}, **info[n]} for n in names}, "noise_um": {c: x / UM for c, x in clean_noisy.items()}, "plain_um": {c: v / UM for c, v in plain.items()}, "summary": summ, "hardware": H, "motion": {k: v for k, v in mlaw.items()}, "temperature": tl, "attempt": attempt}
        un = kind == "unlisted"
        places = list(UNLISTED[names[0]][1]) if un else []
        return {"case": cid, "kind": kind, "effects": [] if un else list(names), "unlisted": names[0] + ": " + UNLISTED[names[0]][0] if un else None, "places": places, "form": form, "law": clean(law)}
    raise RuntimeError(f"{cid} {names}: no draw fits")

def programme(base):
    """what is drawn in the three sets together, so that names are balanced over them"""
    r = np.random.default_rng(base); s = CATALOGUE * 3; s.remove(str(r.choice(CATALOGUE))); s = [str(x) for x in r.permutation(s)]
    u = list(UNLISTED) * 2 + [str(x) for x in r.permutation(list(UNLISTED))[:8]]; u = [str(x) for x in r.permutation(u)]
    n1, n2, nu = (19, 19, 18), (19, 18, 19), (14, 15, 15); sets = []
    for k in range(3):
        L = [("one", [s.pop()]) for _ in range(n1[k])]
        for _ in range(n2[k]):
            while True:
                a, b = (str(x) for x in r.choice(CATALOGUE, 2, replace=False))
                if {a, b} != {"excess_noise", "outlier_bursts"} and set(("beacon",)) & set(allowed_forms([a, b])): break
            L.append(("two", [a, b]))
        L += [("none", [])] * 8 + [("unlisted", [u.pop()]) for _ in range(nu[k])]
        sets.append([L[i] for i in r.permutation(len(L))])
    return sets

def main():
    ap = argparse.ArgumentParser(); ap.add_argument("--set", type=int, required=True, choices=(1, 2, 3)); ap.add_argument("--out", required=True); ap.add_argument("--only", default=""); a = ap.parse_args()
    folder = "b"; base = zlib.crc32(f"judge/{folder}".encode()); cases = programme(base)[a.set - 1]; os.makedirs(a.out, exist_ok=True); truth = []; t0 = time.time()
    for k, (kind, names) in enumerate(cases):
        cid = f"c{k:03d}"
        if a.only and cid not in a.only.split(","): continue
        q = one_case(base % 1000003 * 1000 + a.set * 100 + k, kind, names, a.out, cid); truth.append(q)
        print(f"{time.time() - t0:6.1f} {cid} {kind:8s} {q['form']:9s} {'+'.join(names)} att {q['law']['attempt']} n {q['law']['summary']['first']['samples']} " + " ".join(f"{n}:{ {c: round(v, 2) for c, v in i['excess_um'].items()} }" for n, i in q["law"]["effects"].items()), flush=True)
    json.dump(truth, open(os.path.join(a.out, "truth.json"), "w"), indent=1)
if __name__ == "__main__": main()
