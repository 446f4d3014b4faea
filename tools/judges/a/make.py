#!/usr/bin/env python3
"""A planar robot's position sensors simulated from the plant's side: pose -> flux -> counts.
usage: python make.py --set K --out DIR"""
import os
for _v in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_v, "1")
import argparse, json, math, zlib
import numpy as np

HERE = os.path.basename(os.path.dirname(os.path.abspath(__file__)))
RHO, LS = 1.016e-3, 9.7e-3
F = 2 * np.pi / RHO
UM = 1e-6
SGN = np.array([1., 1., -1., -1.])          # sign of theta in p1..p4  (p = x,y +- l_s/2 theta)
LAT = np.array([-1., 1., 1., -1.])          # sign of theta in the lateral coordinate, equation (9)
ISX = np.array([True, False, True, False])
GP = np.array([1., -1., -1., 1.])           # g_p = p1 - p3 - p2 + p4
ORD = (1, 2, 4, 6)

CATALOGUE = ["lateral_dependence", "extra_harmonics", "tooth_variation", "angle_dependence", "psd_nonlinearity",
             "psd_misalignment", "thermal_drift", "velocity_lag", "psd_latency", "hysteresis", "gap_variation",
             "beacon_vibration", "axis_skew", "cycle_slip", "outlier_bursts", "excess_noise", "adc_clipping",
             "quadrature_drift", "span_error"]
BEACON_ONLY = {"lateral_dependence", "psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew"}
NOT_POSITIONS = {"adc_clipping", "gap_variation"}
REF_OK = {"extra_harmonics", "tooth_variation", "thermal_drift", "velocity_lag", "hysteresis", "gap_variation",
          "cycle_slip", "outlier_bursts", "excess_noise", "adc_clipping", "quadrature_drift"}
UNSCALED = {"cycle_slip", "outlier_bursts", "excess_noise"}
OWN, TIME, FREQ, SPEED, PLACE = r"own (tooth )?phase", "time", "frequency|vibration", "speed", "place|platen"
DIRN, DEFL, ANG, AMP, LATR = "direction", "deflection", "theta|angle", "amplitude", "lateral"
# name: (description, places, forms it may be drawn in, acts only in motion)
UNLISTED = {
 "mains_hum": ("mains hum picked up by a quadrature pair (fundamental and third)", [FREQ, TIME, OWN], "bnpr", False),
 "axis_crosstalk": ("flux of one axis' segment leaks into a segment of the other axis: product of own and lateral phase", [LATR, OWN, r"tooth phase"], "bnp", False),
 "clock_jitter": ("random jitter of a segment's sampling instant: noise in proportion to speed", [SPEED], "bnpr", True),
 "sampling_beat": ("asynchronous converter: age of the sample runs as a saw-tooth in time, error = speed x age", [SPEED, TIME, FREQ], "bnpr", True),
 "head_knocked": ("a sensor head is knocked by a fraction of a tooth at some moment", [TIME], "bnpr", False),
 "loose_head": ("loose screw: a head toggles between two seats at random moments (telegraph)", [TIME, FREQ], "bnpr", False),
 "beacon_knocked": ("the beacon is knocked by some micrometres at some moment", [TIME], "b", False),
 "ambient_light": ("uneven room light on the diode that comes and goes within minutes", [TIME, DEFL], "b", False),
 "etalon_ripple": ("interference ripple of the diode's window, periodic in the spot's place", [DEFL, PLACE], "b", False),
 "magnetised_spot": ("a magnetised spot of the platen biases the coils near it (offsets bound to place, amplitude kept)", [PLACE, OWN, AMP], "bnr", False),
 "tether_strain": ("the umbilical's pull strains the body: a smooth quadratic function of place over the whole stroke", [PLACE], "bnp", False),
 "aero_lift": ("the air bearing's film grows with the square of speed and shifts the heads, alike in both directions", [SPEED, AMP], "bnpr", True),
 "cable_twist": ("cable torque twists the body: heads shift with theta squared and |theta|", [ANG], "bnp", False),
 "head_compliance": ("heads on compliant flexures lag in proportion to acceleration", [SPEED, TIME, DIRN], "bnp", True),
 "carrier_resonance": ("a coil carrier rings at its resonance, driven by turbulence: narrow-band noise of one segment", [FREQ, TIME], "bnpr", False),
 "abbe_tilt": ("the courier tips under acceleration: the diode, high above the platen, is displaced", [SPEED, TIME, DIRN], "b", True),
 "hold_current": ("drive current decays from its moving to its holding level after each stop and biases the coils meanwhile", [TIME, SPEED, OWN], "bnp", False),
}
MOVING = {"velocity_lag", "psd_latency"} | {k for k, v in UNLISTED.items() if v[3]}


def logu(r, a, b, size=None):
    return np.exp(r.uniform(math.log(a), math.log(b), size))


def pm(r, a, b, size=None):
    return r.uniform(a, b, size) * r.choice([-1., 1.], size)


def smooth(r, t, total, lo=0.2, hi=1.6, n=6):
    """a smooth random course of about unit rms, periods lo..hi of the total"""
    y = np.zeros_like(t)
    for _ in range(n):
        y += np.sin(2 * np.pi * t / (total * logu(r, lo, hi)) + r.uniform(0, 2 * np.pi)) * r.uniform(.4, 1)
    return y / math.sqrt(n * .52 / 2)


def rot(th, x, y):
    return np.cos(th) * x - np.sin(th) * y, np.sin(th) * x + np.cos(th) * y


# ------------------------------------------------------------------ hardware, plain imperfections
def hardware(r, form):
    hw = dict(form=form, counts=form != "positions")
    hw["psd"] = form == "beacon" or (form == "positions" and r.random() < .6)
    hw["A"] = float(round(r.uniform(20000, 26500)))
    hw["qn"] = float(round(r.uniform(10, 25), 1))
    hw["pn"] = float(round(logu(r, .05, .3), 3)) * UM
    hw["goff"] = pm(r, .001, .005, (2, 4))
    hw["gain"] = pm(r, .008, .045, 4)
    hw["psi"] = np.deg2rad(pm(r, .4, 3., 4))
    hw["h3"] = pm(r, .001, .006, 4)
    hw["zero"] = r.uniform(-6, 6, 4) * UM
    hw["lo"] = r.uniform(3.2e-3, 7.5e-3)
    if abs(hw["lo"] - LS / 2) < .3e-3:
        hw["lo"] += .8e-3
    hw["h"] = r.uniform(.02, .04)
    hw["lx"], hw["ly"] = r.uniform(.08, .1) * r.choice([-1, 1]), r.uniform(-.012, .012)
    hw["tfs"] = round(r.uniform(.006, .0095) / hw["h"], 3)
    hw["nom"] = (round(hw["h"] * (1 + r.uniform(-.03, .03)), 4), round(hw["lx"] + r.uniform(-1, 1) * 1e-3, 4), round(hw["ly"] + r.uniform(-.6, .6) * 1e-3, 4))
    hw["S"], hw["pn_psd"] = float(round(r.uniform(26000, 38000), -2)), float(round(r.uniform(1., 2.8), 1))
    hw["B"] = np.array([r.uniform(.055, .12), r.uniform(.05, .1)]) * r.choice([-1, 1], 2)   # courier centre under the beacon
    hw["o"] = hw["B"] - np.array([hw["lx"], hw["ly"]])
    hw["c0"] = np.array([r.uniform(-2, 2), r.uniform(-2, 2)]) * 1e-3                        # corner of the scatter area
    hw["temp"] = True
    hw["T0"] = r.uniform(21, 30)
    hw["seg"] = 0
    return hw


# ------------------------------------------------------------------ motion
def ramp(t, V, L, ta):
    """distance along a stroke of length L at speed V, smooth ramps of ta at both ends"""
    tt = L / V + ta
    def acc(u):
        return V * ta * (u ** 3 - u ** 4 / 2)
    a = np.clip(t / ta, 0, 1)
    b = np.clip((tt - t) / ta, 0, 1)
    mid = np.clip(t - ta, 0, tt - 2 * ta)
    return np.where(t <= ta, acc(a), np.where(t >= tt - ta, L - acc(b), V * ta / 2 + V * mid)), tt


def plan(r, hw):
    """what the courier will run, the same in both recordings"""
    b = hw["psd"]
    P = dict(nsc=int(r.integers(260, 420)), nbe=int(r.integers(240, 380)), spp=(int(r.integers(2, 4)), int(r.integers(5, 9))),
             fs_s=logu(r, 90, 400), fs_f=r.uniform(220, 560), fs_b=r.uniform(350, 900), fs_slow=r.uniform(70, 150),
             fs_spin=r.uniform(70, 140), fs_still=logu(r, 200, 1000), ta=r.uniform(.09, .2), tb=r.uniform(.05, .1),
             vslow=r.uniform(8e-3, 14e-3), nstill=int(r.integers(350, 700)), tspin=r.uniform(5, 9), move=r.uniform(.35, .8))
    if hw["form"] == "reference":
        P["runs"] = ["scatter", "flyby_x", "flyby_x_back", "flyby_x_slow", "flyby_x", "flyby_x_back", "still"]
        P["nsc"] = int(r.integers(400, 600))
        return P
    runs = ["scatter", "flyby_x", "flyby_x_back", "flyby_y", "flyby_y_back", "flyby_y_slow"]
    if b:
        bl = ["beacon", "beacon_x", "beacon_x_back", "beacon_y", "beacon_y_back"]
        runs = runs + bl if r.random() < .7 else bl + runs
    runs += ["spin", "still"]
    for k in ("flyby_y_slow", "spin", "still"):
        if r.random() < .1:
            runs.remove(k)
    P["runs"] = runs
    return P


class Rec:
    pass


def drive(r, hw, P, which, dT):
    """true poses of one recording"""
    ref = hw["form"] == "reference"
    cols = {k: [] for k in ("t", "x", "y", "th", "cx", "cy", "cth", "run", "stretch", "vx", "vy", "vth", "ax", "ay", "ath", "still", "since", "pdx", "pdy")}
    clock = [r.uniform(.5, 3.)]
    ns = [0]
    last = [None]
    inset = 1. if which == 0 else .97
    o, l = hw["o"], np.array([hw["lx"], hw["ly"]])
    ol = r.normal(0, 15, 2) * UM

    def put(run, t, x, y, th, v=None, a=None, still=False, since=0., err=None):
        n = len(t)
        z = np.zeros(n)
        e = err if err is not None else (r.normal(0, 18 * UM), r.normal(0, 18 * UM), r.normal(0, 2e-4))
        wob = 6 * UM * np.sin(2 * np.pi * (t - t[0]) * 1.3 + r.uniform(0, 6))
        if ref:
            e, = [(e[0], e[1], 0.)]
        vals = dict(t=t, x=x + z, y=y + z, th=th + z, cx=x + z + e[0] + ol[0] + (0 if still else wob), cy=y + z + e[1] + ol[1] + (0 if still else wob),
                    cth=th + z + e[2], run=np.full(n, run, object), stretch=np.full(n, ns[0]), still=np.full(n, still), since=since + z)
        v = v or (z, z, z); a = a or (z, z, z)
        for k, q in zip(("vx", "vy", "vth", "ax", "ay", "ath"), tuple(v) + tuple(a)):
            vals[k] = q
        for k, q in vals.items():
            cols[k].append(np.asarray(q))
        ns[0] += 1
        clock[0] = t[-1]

    def poses(run, n, draw, fs):
        for _ in range(n):
            k = int(r.integers(P["spp"][0], P["spp"][1] + 1))
            t0 = clock[0] + max(P["move"] * r.uniform(.8, 1.3), 15 / fs)
            t = t0 + np.arange(k) / fs
            x, y, th = draw()
            settle = r.uniform(.03, .06)
            put(run, t, x, y, th, still=True, since=t - t0 + settle)

    def moving(run, fn, T, fs):
        n = int(T * fs)
        tl = np.arange(n + 1) / fs
        tl = tl[tl <= T]
        e = 1e-4
        p0, pp, pn = fn(tl), fn(tl + e), fn(tl - e)
        v = [(a - b) / (2 * e) for a, b in zip(pp, pn)]
        pp, pn = fn(tl + 2e-3), fn(tl - 2e-3)
        a = [(u - 2 * w + q) / 4e-6 for u, w, q in zip(pp, p0, pn)]
        put(run, clock[0] + r.uniform(1.5, 6) + tl, *p0, v=v, a=a)

    def wander(amp, T):
        w = [(amp * r.uniform(.3, 1), r.uniform(.4, 3.), r.uniform(0, 6.3)) for _ in range(3)]
        return lambda t: sum(A * np.sin(2 * np.pi * f * t + p) for A, f, p in w)

    ctr = hw["c0"] + 5 * RHO
    for run in P["runs"]:
        if run == "scatter":
            if ref:
                poses(run, P["nsc"], lambda: (ctr[0] + r.uniform(-5, 5) * RHO * inset, ctr[1], 0.), P["fs_s"])
            else:
                poses(run, P["nsc"], lambda: (ctr[0] + r.uniform(-5, 5) * RHO * inset, ctr[1] + r.uniform(-5, 5) * RHO * inset,
                                              np.deg2rad(.5) * r.uniform(-1, 1) * inset), P["fs_s"])
        elif run == "beacon":
            def dr():
                th = np.deg2rad(1.5) * r.uniform(-1, 1) * inset
                c = r.uniform(-1, 1, 2) * RHO * inset
                q = rot(th, l[0] + c[0], l[1] + c[1])
                return o[0] + q[0], o[1] + q[1], th
            poses(run, P["nbe"], dr, P["fs_s"])
        elif run.startswith("flyby"):
            ax = 0 if "_x" in run else 1
            V = P["vslow"] if "slow" in run else .05
            d = -1 if "back" in run else 1
            if "slow" in run:
                d = r.choice([-1, 1])
            off = r.uniform(-.3, .3, 2) * 1e-3 if not ref else np.array([r.uniform(-.3, .3) * 1e-3, 0.])
            th0 = 0. if ref else r.uniform(-2.5e-3, 2.5e-3)
            wl, wt = wander(20 * UM, 1), wander(1e-4, 1)
            ta = P["ta"] if "slow" not in run else .2
            T = .04 / V + ta
            def fn(t, ax=ax, V=V, d=d, off=off, th0=th0, wl=wl, wt=wt, ta=ta):
                s, _ = ramp(t, V, .04, ta)
                q = [ctr[0] + off[0] + 0 * t, ctr[1] + off[1] + 0 * t]
                q[ax] = q[ax] + d * (s - .02)
                if not ref:
                    q[1 - ax] = q[1 - ax] + wl(t)
                return q[0], q[1], (0 * t if ref else th0 + wt(t))
            moving(run, fn, T, P["fs_slow"] if "slow" in run else P["fs_f"])
        elif run.startswith("beacon_"):
            ax = 0 if "_x" in run else 1
            d = -1 if "back" in run else 1
            off = r.uniform(-.25, .25, 2) * 1e-3
            th0 = r.uniform(-5e-3, 5e-3)
            wl, wt = wander(12 * UM, 1), wander(8e-5, 1)
            T = .008 / .02 + P["tb"]
            def fn(t, ax=ax, d=d, off=off, th0=th0, wl=wl, wt=wt):
                s, _ = ramp(t, .02, .008, P["tb"])
                th = th0 + wt(t)
                q = list(rot(th0, l[0] + off[0], l[1] + off[1]))
                q[ax] = q[ax] + d * (s - .004)
                q[1 - ax] = q[1 - ax] + wl(t)
                return o[0] + q[0], o[1] + q[1], th
            moving(run, fn, T, P["fs_b"])
        elif run == "spin":
            per = P["tspin"] / r.choice([1, 2])
            ph = r.uniform(0, 6.3)
            c = r.uniform(-.3, .3, 2) * 1e-3
            def fn(t, per=per, ph=ph, c=c):
                th = np.deg2rad(1.2) * inset * np.sin(2 * np.pi * t / per + ph)
                q = rot(th, l[0] + c[0], l[1] + c[1])
                base = o if hw["psd"] else ctr - l
                return base[0] + q[0], base[1] + q[1], th
            moving(run, fn, P["tspin"], P["fs_spin"])
        elif run == "still":
            if hw["psd"]:
                x, y, th = hw["B"][0] + r.uniform(-.3, .3) * 1e-3, hw["B"][1] + r.uniform(-.3, .3) * 1e-3, r.uniform(-1e-3, 1e-3)
            else:
                x, y, th = ctr[0] + r.uniform(-3, 3) * 1e-3, ctr[1] + (0 if ref else r.uniform(-3, 3) * 1e-3), 0. if ref else r.uniform(-1e-3, 1e-3)
            t0 = clock[0] + r.uniform(1.5, 4)
            t = t0 + np.arange(P["nstill"]) / P["fs_still"]
            put(run, t, x, y, th, still=True, since=t - t0 + .5)
        clock[0] += r.uniform(2, 15)
    R = Rec()
    cols.pop("pdx"); cols.pop("pdy")
    for k, v in cols.items():
        setattr(R, k, np.concatenate(v))
    R.t = np.round(R.t, 6)
    assert (np.diff(R.t) > 0).all()
    R.N, R.T = len(R.t), R.t[-1]
    R.moving = (np.hypot(R.vx, R.vy) > 2e-3)
    # temperature: warm-up, and a fan or a door besides
    u = R.t / R.T
    f = 1 if which == 0 else r.uniform(.85, 1.)
    tau = r.uniform(.25, .6)
    tt = np.linspace(0, 1, 400)
    def course(u):
        return (1 - np.exp(-u / tau)) + .28 * np.sin(2 * np.pi * u * cyc + phs)
    cyc, phs = r.uniform(1.2, 2.6), r.uniform(0, 6.3)
    cc = course(tt)
    R.temp = hw["T0"] + r.uniform(-.02, .02) * dT + f * dT * (course(u) - cc.min()) / (cc.max() - cc.min())
    R.dT = R.temp - hw["T0"] - dT / 2
    # what the segments' positions are, drawing geometry
    R.p = np.where(ISX[:, None], R.x, R.y) + SGN[:, None] * (LS / 2) * R.th
    R.v = np.where(ISX[:, None], R.vx, R.vy) + SGN[:, None] * (LS / 2) * R.vth
    R.a = np.where(ISX[:, None], R.ax, R.ay) + SGN[:, None] * (LS / 2) * R.ath
    R.q = np.where(ISX[:, None], R.y, R.x) + LAT[:, None] * hw["lo"] * R.th
    # where each segment's centre is on the platen
    R.sx = np.where(ISX[:, None], R.p, R.q)
    R.sy = np.where(ISX[:, None], R.q, R.p)
    return R


# ------------------------------------------------------------------ laws: drawn once a case
def law(name, r, hw):
    L = {}
    sub = np.ones(4) if hw["form"] == "reference" else None
    def some(p=.6):
        if sub is not None:
            return sub
        m = (r.random(4) < p).astype(float)
        if not m.any():
            m[r.integers(4)] = 1
        return m
    if name == "lateral_dependence":
        L = dict(a1=r.uniform(.4, 1.5, 4) * some(.75), ph1=r.uniform(0, 6.3, 4), a2=r.uniform(0, .8, 4) * some(.6), ph2=r.uniform(0, 6.3, 4), am=r.uniform(0, .015))
    elif name == "extra_harmonics":
        ms = list(r.choice([-2, 4, -4, 6, 8, 9, -7, 11], int(r.integers(1, 4)), replace=False))
        L = dict(m=[int(m) for m in ms], c=[[complex(*r.normal(0, .004, 2)) for _ in range(4)] for _ in ms])
    elif name == "tooth_variation":
        L = dict(seed=int(r.integers(1 << 30)), along=float(r.integers(2, 6)) + r.uniform(0, 1), across=float(r.integers(1, 7)) + r.uniform(0, 1), line=r.uniform(0, .5), heavy=bool(r.random() < .35))
    elif name == "angle_dependence":
        L = dict(dpsi=pm(r, 1., 5, 4) * some(.7), off=(r.normal(0, 1, 4) + 1j * r.normal(0, 1, 4)) * some(.5) * r.choice([0., 1.5]), quad=r.normal(0, 60, 4) * r.choice([0, 1]), w=r.uniform(2e-3, 6e-3))
    elif name == "psd_nonlinearity":
        L = dict(k3=pm(r, .01, .06, 2), k12=r.normal(0, .03, 2), k2=r.normal(0, .006, 2) * r.choice([0, 1]), k11=r.normal(0, .006, 2) * r.choice([0, 1]), law=str(r.choice(["poly", "sine"])))
    elif name == "psd_misalignment":
        L = dict(turn=pm(r, .5e-3, 6e-3), gain=pm(r, .5e-3, 2e-3), shear=r.normal(0, .7e-3) * r.choice([0, 1]))
    elif name == "thermal_drift":
        L = dict(c=r.normal(0, .4, 4) * UM, alpha=r.uniform(3e-6, 18e-6), lag=r.uniform(0, 12), curve=r.uniform(-.02, .02), amp=-r.uniform(0, 8e-4))
    elif name == "velocity_lag":
        L = dict(tau=(r.uniform(5, 40) * r.choice([0, 1]) + r.uniform(0, 60, 4) * some(.7)) * 1e-6, kind=str(r.choice(["filter", "eddy", "delay"])), vc=r.uniform(.03, .15),
                 skew=r.normal(0, 15e-6, 4) * r.choice([0, 1]))
    elif name == "psd_latency":
        L = dict(dt=pm(r, 60e-6, 300e-6))
    elif name == "hysteresis":
        L = dict(b=pm(r, .5, 3, 4) * some(.75) * UM, D=logu(r, 15e-6, 250e-6), kind=str(r.choice(["dahl", "play"])), r=logu(r, 8e-6, 200e-6, 4))
    elif name == "gap_variation":
        n = int(r.integers(3, 7))
        L = dict(k=1 / logu(r, .014, .07, n), dirn=r.uniform(0, 6.3, n), ph=r.uniform(0, 6.3, n), a=r.uniform(.5, 1.2, n) * 8e-6, tilt=r.normal(0, 1e-4, 2),
                 h3=pm(r, .015, .05, 4), kap=r.normal(0, .03, 4), leak=(r.normal(0, .012, 4) + 1j * r.normal(0, .012, 4)))
    elif name == "beacon_vibration":
        n = int(r.integers(1, 4))
        L = dict(f=logu(r, 6, 110, n), a=r.uniform(.4, 1.5, n) * UM, dirn=r.uniform(0, np.pi, n), ell=r.uniform(0, .4, n))
    elif name == "axis_skew":
        k = r.choice(3)
        L = dict(pitch=pm(r, .5e-3, 2e-3) if k != 1 else 0., skew=pm(r, .6e-3, 2.5e-3) if k != 0 else 0.)
    elif name == "cycle_slip":
        n = 1 if sub is not None else int(r.integers(1, 3))
        L = dict(seg=[int(i) for i in (r.choice(4, n, replace=False) if sub is None else [hw["seg"]])], teeth=[int(r.choice([-1, 1, 1, -1, 2, -2])) for _ in range(n)], together=bool(r.random() < .5))
    elif name in ("outlier_bursts", "excess_noise"):
        scope = str(r.choice(["segments", "segments", "all", "psd"] if hw["psd"] else ["segments", "all"]))
        seg = some(.4) if scope == "segments" else (np.ones(4) if scope == "all" else np.zeros(4))
        if name == "outlier_bursts":
            L = dict(scope=scope, seg=seg, frac=logu(r, .012, .09), length=r.uniform(1, 7), lo=r.uniform(10, 25), hi=r.uniform(40, 100), kind=str(r.choice(["spike", "ring", "noise"])))
        else:
            L = dict(scope=scope, seg=seg, factor=logu(r, 1.6, 6))
    elif name == "adc_clipping":
        ch = (r.random((2, 4)) < .4)
        if sub is not None:
            ch[:] = r.random((2, 1)) < .6
        if not ch.any():
            ch[r.integers(2), :] = True if sub is not None else ch[0]
            ch[r.integers(2), r.integers(4)] = True
        if sub is not None and not ch[:, hw["seg"]].any():
            ch[0, :] = True
        L = dict(ch=ch, side=str(r.choice(["both", "both", "top"])), kind=str(r.choice(["hard_amp", "hard_adc", "soft"])), soft=r.uniform(6, 14), depth=r.uniform(.05, .15), spread=r.uniform(.85, 1.15, (2, 4)))
    elif name == "quadrature_drift":
        L = dict(seg=some(.5), off=r.uniform(.2, 1) * r.choice([0, 1, 1]) * .01, gain=r.uniform(.2, 1) * r.choice([0, 1]) * .02, psi=r.uniform(.2, 1) * r.choice([0, 1]) * .02, lo=r.uniform(.15, .4))
        if L["off"] == L["gain"] == L["psi"] == 0:
            L["off"] = .006
    elif name == "span_error":
        L = dict(d=r.normal(0, .25e-3, 4), same=r.normal(0, .15e-3, 2))
    # ---- unlisted
    elif name == "mains_hum":
        L = dict(f=float(r.choice([50.03, 59.96])), seg=some(.5), off=r.normal(0, .01, 4) + 1j * r.normal(0, .01, 4), third=r.uniform(0, .4))
    elif name == "axis_crosstalk":
        M = np.zeros((4, 4), complex)
        for i in range(4):
            for j in range(4):
                if ISX[i] != ISX[j]:
                    M[i, j] = complex(*r.normal(0, .01, 2)) * (r.random() < .7)
        if not M.any():
            M[0, 1] = .01
        L = dict(M=M, part=str(r.choice(["both", "sine"])))
    elif name == "clock_jitter":
        L = dict(seg=some(.5), sig=30e-6)
    elif name == "sampling_beat":
        L = dict(seg=some(.5), f=logu(r, 1.5, 25), age=80e-6)
    elif name == "head_knocked":
        L = dict(seg=int(r.integers(4)) if sub is None else hw["seg"], step=float(pm(r, 3, 6)) * UM)
    elif name == "loose_head":
        L = dict(seg=int(r.integers(4)) if sub is None else hw["seg"], step=5 * UM, dwell=logu(r, 8, 60))
    elif name == "beacon_knocked":
        a = r.uniform(0, 6.3)
        L = dict(step=[5 * UM * math.cos(a), 5 * UM * math.sin(a)])
    elif name == "ambient_light":
        L = dict(bias=r.normal(0, 1, 2) * .001, level=r.uniform(.005, .03), lo=r.uniform(.04, .12))
    elif name == "etalon_ripple":
        L = dict(period=r.uniform(.25e-3, .7e-3, 2), amp=r.uniform(.5, 1.5, 2) * UM, ph=r.uniform(0, 6.3, 2), cross=r.uniform(-.7, .7))
    elif name == "magnetised_spot":
        n = int(r.integers(1, 4))
        L = dict(at=r.uniform(-1, 1, (n, 2)) * np.array([[.008, .008]]), w=r.uniform(2.5e-3, 6e-3, n), off=(r.normal(0, .01, n) + 1j * r.normal(0, .01, n)), ratio=r.uniform(.6, 1.4, 4))
    elif name == "tether_strain":
        L = dict(q=r.normal(0, 1, (4, 3)), s=r.normal(0, .5, (4, 2)))
    elif name == "aero_lift":
        L = dict(k=r.normal(0, 1, 4) * UM, amp=-r.uniform(.005, .03), p=r.uniform(1.7, 2.2))
    elif name == "cable_twist":
        L = dict(k2=r.normal(0, 1, 4), k1=r.normal(0, 1, 4))
    elif name == "head_compliance":
        L = dict(wn=2 * np.pi * r.uniform(60, 160, 4), cross=r.normal(0, .2, 4))
    elif name == "carrier_resonance":
        L = dict(seg=int(r.integers(4)) if sub is None else hw["seg"], f=r.uniform(14, 40), Q=r.uniform(8, 30))
    elif name == "abbe_tilt":
        L = dict(kx=pm(r, .5, 1.5), ky=pm(r, .5, 1.5), cross=r.normal(0, .2))
    elif name == "hold_current":
        L = dict(tau=r.uniform(.04, .12), rest=r.uniform(0, .2), dc=r.normal(0, 1, 4) * UM, off=r.normal(0, .006, 4) + 1j * r.normal(0, .006, 4))
    else:
        raise KeyError(name)
    return L


# ------------------------------------------------------------------ effects: what they do to the plant
class Acc:
    def __init__(s, R):
        n = R.N
        s.dp = np.zeros((4, n)); s.amp = np.ones((4, n)); s.h3 = np.ones((4, n)); s.h3base = None
        s.off = np.zeros((4, n), complex); s.gain = np.zeros((4, n)); s.psi = np.zeros((4, n))
        s.harm = []; s.clip = None; s.qadd = np.zeros((4, n), complex); s.padd = np.zeros((4, n)); s.psdadd = np.zeros((4, n))
        s.slip = np.zeros((4, n), int); s.beacon = np.zeros((2, n)); s.dc = np.zeros((2, n)); s.dtc = 0.
        s.cmd = np.zeros((2, n)); s.dfun = []; s.mix = None; s.mixpart = "both"; s.sigfix = []


def footprint(field, u, w, M, K):
    """box footprint of M by K teeth, edges weighted in part; u along, w across, in teeth"""
    n0, m0 = int(math.ceil(M)) + 2, int(math.ceil(K)) + 2
    fu, fw = np.floor(u).astype(int), np.floor(w).astype(int)
    H = field.shape[0] // 2
    out = np.zeros_like(u)
    tot = np.zeros_like(u)
    wa = [(k, np.clip(M / 2 + .5 - np.abs(u - fu - k), 0, 1)) for k in range(-n0 // 2 - 1, n0 // 2 + 2)]
    wc = [(k, np.clip(K / 2 + .5 - np.abs(w - fw - k), 0, 1)) for k in range(-m0 // 2 - 1, m0 // 2 + 2)]
    for k, a in wa:
        if not a.any():
            continue
        for j, c in wc:
            ww = a * c
            out += ww * field[(fu + k + H) % (2 * H), (fw + j + H) % (2 * H)]
            tot += ww
    return out / tot


def apply(name, L, s, R, hw, A, r):
    """r: this recording's own generator (events, courses, noise of the effect)"""
    t, N = R.t, R.N
    if name == "lateral_dependence":
        q = F * R.q
        A.dp += s * UM * (L["a1"][:, None] * np.sin(q + L["ph1"][:, None]) + L["a2"][:, None] * np.sin(2 * q + L["ph2"][:, None]))
        A.amp *= 1 + L["am"] * np.cos(q)
    elif name == "extra_harmonics":
        for m, c in zip(L["m"], L["c"]):
            A.harm.append((m, s * np.array(c)))
    elif name == "tooth_variation":
        g = np.random.default_rng(L["seed"])
        fl = []
        for _ in range(2):
            f = g.standard_t(3, (512, 512)) / 1.7 if L["heavy"] else g.standard_normal((512, 512))
            fl.append(f + L["line"] * g.standard_normal((512, 1)))
        for i in range(4):
            A.dp[i] += s * 5 * UM * footprint(fl[0 if ISX[i] else 1], R.p[i] / RHO, R.q[i] / RHO, L["along"], L["across"])
    elif name == "angle_dependence":
        th = R.th
        A.psi += s * L["dpsi"][:, None] * th + s * L["quad"][:, None] * th ** 2
        A.off += s * L["off"][:, None] * th
        x = F * L["w"] * th / 2
        A.amp *= np.sinc(x / np.pi)
        A.h3 *= np.sinc(3 * x / np.pi) / np.sinc(x / np.pi)
    elif name == "psd_nonlinearity":
        def fn(d):
            x, y = d
            o = []
            for i, (a, b) in enumerate(((x, y), (y, x))):
                if L["law"] == "poly":
                    e = L["k3"][i] * a ** 3
                else:
                    w = math.sqrt(6) * 1.2
                    e = -L["k3"][i] * (np.sin(w * a) - w * a) * 6 / w ** 3
                o.append(a + s * (e + L["k12"][i] * a * b * b + L["k2"][i] * a * a + L["k11"][i] * a * b))
            return np.array(o)
        A.dfun.append(fn)
    elif name == "psd_misalignment":
        def fn(d):
            x, y = rot(s * L["turn"], *d)
            return np.array([x * (1 + s * L["gain"]) + s * L["shear"] * y, y * (1 - s * L["gain"])])
        A.dfun.append(fn)
    elif name == "thermal_drift":
        T = R.dT.copy()
        if L["lag"] > .3:
            for k in range(1, N):
                T[k] = R.dT[k] + (T[k - 1] - R.dT[k - 1]) * math.exp(-(t[k] - t[k - 1]) / L["lag"]) - (R.dT[k] - R.dT[k - 1]) * math.exp(-(t[k] - t[k - 1]) / L["lag"])
        T = T + L["curve"] * T * T
        A.dp += s * (L["c"][:, None] * T + min(1, 1 / max(s, 1e-9)) * L["alpha"] * T * (R.p - np.where(ISX, hw["c0"][0], hw["c0"][1])[:, None]))
        A.amp *= 1 + L["amp"] * T
    elif name == "velocity_lag":
        tau = s * L["tau"][:, None]
        if L["kind"] == "filter":
            A.dp -= np.arctan(F * R.v * tau) / F - R.a * tau ** 2
            A.amp /= np.sqrt(1 + (F * R.v * tau) ** 2)
        elif L["kind"] == "eddy":
            A.dp -= tau * R.v / (1 + (R.v / L["vc"]) ** 2)
            A.amp /= 1 + .05 * (R.v / L["vc"]) ** 2
        else:
            A.dp -= tau * R.v - R.a * tau ** 2 / 2
        A.psi += F * s * L["skew"][:, None] * R.v
    elif name == "psd_latency":
        A.dtc += s * L["dt"]
    elif name == "hysteresis":
        for i in range(4):
            if L["b"][i] == 0:
                continue
            p = R.p[i].tolist()
            z = np.empty(N)
            if L["kind"] == "dahl":
                y, D = 0., L["D"]
                z[0] = 0
                for k in range(1, N):
                    d = p[k] - p[k - 1]
                    if d > 0:
                        y = 1 + (y - 1) * math.exp(-d / D)
                    elif d < 0:
                        y = -1 + (y + 1) * math.exp(d / D)
                    z[k] = y
            else:
                z[:] = 0
                for rr in L["r"]:
                    y = p[0]
                    for k in range(N):
                        y = min(max(y, p[k] - rr), p[k] + rr)
                        z[k] += (p[k] - y) / rr / len(L["r"])
            A.dp[i] -= s * L["b"][i] * z
    elif name == "gap_variation":
        def g(x, y):
            o = L["tilt"][0] * x + L["tilt"][1] * y
            for k, dd, ph, a in zip(L["k"], L["dirn"], L["ph"], L["a"]):
                o = o + a * np.cos(2 * np.pi * k * (x * math.cos(dd) + y * math.sin(dd)) + ph)
            return o
        ctr = hw["c0"] + 5 * RHO
        G = s * (g(R.sx, R.sy) - g(ctr[0], ctr[1]))
        G = 150e-6 * np.tanh(G / 150e-6)
        A.gap = G
        A.amp *= np.exp(-F * G)
        A.h3 *= np.exp(-2 * F * G)
        A.h3base = L["h3"]
        A.off += L["leak"][:, None]                       # stray flux that does not shrink with the gap
        A.dp += L["kap"][:, None] * G
    elif name == "beacon_vibration":
        for f, a, dd, e in zip(L["f"], L["a"], L["dirn"], L["ell"]):
            ph = r.uniform(0, 6.3)
            u, w = np.cos(2 * np.pi * f * t + ph), e * np.sin(2 * np.pi * f * t + ph)
            A.beacon += s * a * np.array(rot(dd, u, w))
    elif name == "axis_skew":
        x, y = R.sx, R.sy
        A.dp += s * np.where(ISX[:, None], L["pitch"] / 2 * (x - hw["B"][0]) + L["skew"] * (y - hw["B"][1]), -L["pitch"] / 2 * (y - hw["B"][1]))
        X, Y = R.x - hw["B"][0], R.y - hw["B"][1]
        A.cmd = s * np.array([L["pitch"] / 2 * X + L["skew"] * Y, -L["pitch"] / 2 * Y])      # open loop steps by the platen's own teeth
    elif name == "cycle_slip":
        t0 = R.t[int(r.uniform(.12, .88) * N)]
        for i, k in zip(L["seg"], L["teeth"]):
            A.slip[i] += k * (t >= t0)
            if not L["together"]:
                t0 = R.t[int(r.uniform(.12, .88) * N)]
    elif name == "outlier_bursts":
        n, hit = 0, np.zeros(N, bool)
        shape = np.zeros(N)
        while n < L["frac"] * N:
            k = int(r.integers(N)); m = min(1 + int(r.poisson(L["length"] - 1)), N - k)
            a = logu(r, L["lo"], L["hi"]) * r.choice([-1, 1])
            w = {"spike": np.ones(m), "ring": np.cos(np.arange(m) * 1.9) * np.exp(-np.arange(m) / 3.), "noise": r.uniform(.5, 1, m) * r.choice([-1, 1], m)}[L["kind"]]
            shape[k:k + m] = a * w
            hit[k:k + m] = True
            n = hit.sum()
        A.law_hit = float(hit.mean())
        for i in range(4):
            if L["seg"][i]:
                ph = np.repeat(r.uniform(0, 6.3, N // 8 + 1), 8)[:N]
                A.qadd[i] += shape * hw["qn"] * np.exp(1j * ph) * 1.4
                A.padd[i] += shape * hw["pn"] * np.where(np.cos(ph) > 0, 1, -1)
        if L["scope"] == "psd":
            for i in range(4):
                A.psdadd[i] += shape * hw["pn_psd"] * r.choice([-1, 1]) * r.uniform(.4, 1)
    elif name == "excess_noise":
        e = math.sqrt(L["factor"] ** 2 - 1)
        for i in range(4):
            a, b, c = r.normal(0, 1, (3, N))
            if L["seg"][i]:
                A.qadd[i] += e * hw["qn"] * (a + 1j * b)
                A.padd[i] += e * hw["pn"] * c
        if L["scope"] == "psd":
            A.psdadd += e * hw["pn_psd"] * r.normal(0, 1, (4, N))
    elif name == "adc_clipping":
        A.clip = (L, s)
    elif name == "quadrature_drift":
        for i in range(4):
            a, b, c, d = [smooth(r, t, R.T, L["lo"], 1.6) for _ in range(4)]
            if L["seg"][i]:
                A.off[i] += s * L["off"] * (a + 1j * b) * .7
                A.gain[i] += s * L["gain"] * c
                A.psi[i] += s * L["psi"] * d
    elif name == "span_error":
        d = L["d"] + np.array([L["same"][0], L["same"][1]] * 2) * SGN
        A.dp += s * d[:, None] * R.th
    # ------------- unlisted
    elif name == "mains_hum":
        ph, p3 = r.uniform(0, 6.3, 2)
        h = np.cos(2 * np.pi * L["f"] * t + ph) + L["third"] * np.cos(6 * np.pi * L["f"] * t + p3)
        A.off += s * (L["seg"] * L["off"])[:, None] * h
    elif name == "axis_crosstalk":
        A.mix, A.mixpart = s * L["M"], L["part"]
    elif name == "clock_jitter":
        A.dp += s * L["sig"] * L["seg"][:, None] * r.normal(0, 1, (4, N)) * R.v
    elif name == "sampling_beat":
        f = L["f"] * r.uniform(.95, 1.05)
        for i in range(4):
            A.dp[i] -= s * L["age"] * L["seg"][i] * R.v[i] * np.mod(f * t + r.uniform(0, 1), 1)
    elif name == "head_knocked":
        t0 = t[int(r.uniform(.2, .8) * N)]
        A.dp[L["seg"]] += s * L["step"] * (t >= t0)
    elif name == "loose_head":
        st = int(r.integers(2)); tn = 0.; z = np.zeros(N)
        while tn < R.T:
            t2 = tn + r.exponential(L["dwell"])
            z[(t >= tn) & (t < t2)] = st
            st, tn = 1 - st, t2
        A.dp[L["seg"]] += s * L["step"] * z
    elif name == "beacon_knocked":
        tb = t[np.isin(R.run, ["beacon", "beacon_x", "beacon_y", "beacon_x_back", "beacon_y_back", "spin", "still"])]
        t0 = tb[int(r.uniform(.2, .7) * len(tb))]
        A.beacon += s * np.array(L["step"])[:, None] * (t >= t0)
    elif name == "ambient_light":
        u = smooth(r, t, R.T, L["lo"], .4)
        a = smooth(r, t, R.T, L["lo"], .4)
        def fn(d):
            lv = L["level"] * (1 + .4 * np.tanh(a)) / 2
            return np.array([(d[0] + s * L["bias"][0] * u) * (1 - lv * min(s, 2) * .1), (d[1] + s * L["bias"][1] * u) * (1 - lv * min(s, 2) * .1)])
        A.dfun.append(fn)
    elif name == "etalon_ripple":
        def fn(d):
            sc = hw["h"] * hw["tfs"]
            x, y = d * sc
            e = [L["amp"][0] * np.sin(2 * np.pi * (x + L["cross"] * y) / L["period"][0] + L["ph"][0]), L["amp"][1] * np.sin(2 * np.pi * (y - L["cross"] * x) / L["period"][1] + L["ph"][1])]
            return d + s * np.array(e) / sc
        A.dfun.append(fn)
    elif name == "magnetised_spot":
        ctr = hw["c0"] + 5 * RHO
        for at, w, of in zip(L["at"], L["w"], L["off"]):
            if hw["form"] == "reference":
                at = at * np.array([1, .1])
            b = np.exp(-((R.sx - ctr[0] - at[0]) ** 2 + (R.sy - ctr[1] - at[1]) ** 2) / (2 * w * w))
            A.off += s * of * L["ratio"][:, None] * b
    elif name == "tether_strain":
        ctr = hw["c0"] + 5 * RHO
        x, y = (R.x - ctr[0]) / .02, (R.y - ctr[1]) / .02
        k = 3.
        x, y = k * np.tanh(x / k), k * np.tanh(y / k)
        B = np.array([x * x, x * y, y * y]); S = np.array([x, y])
        A.dp += s * UM * (L["q"] @ B + L["s"] @ S)
    elif name == "aero_lift":
        sp = np.hypot(R.vx, R.vy) / .05
        A.dp += s * L["k"][:, None] * sp ** L["p"]
        A.amp *= np.exp(L["amp"] * sp ** L["p"])
    elif name == "cable_twist":
        u = R.th / 8.7e-3
        A.dp += s * UM * (L["k2"][:, None] * u * u + L["k1"][:, None] * np.abs(u))
    elif name == "head_compliance":
        A.dp -= s * R.a / L["wn"][:, None] ** 2 + s * L["cross"][:, None] / L["wn"][:, None] ** 2 * np.where(ISX[:, None], R.ay, R.ax)
    elif name == "carrier_resonance":
        y = 0j; z = np.zeros(N); w, g = 2 * np.pi * L["f"], np.pi * L["f"] / L["Q"]
        n = r.normal(0, 1, (N, 2)); tp = t[0]
        y = complex(*r.normal(0, 1, 2))
        for k in range(N):
            dt = t[k] - tp; tp = t[k]
            e = math.exp(-g * dt)
            y = y * e * complex(math.cos(w * dt), math.sin(w * dt)) + math.sqrt(max(0, 1 - e * e)) * complex(n[k, 0], n[k, 1])
            z[k] = y.real
        A.dp[L["seg"]] += s * 2 * UM * z
    elif name == "abbe_tilt":
        k = s * 4e-6
        A.dc += k * np.array([L["kx"] * R.ax + L["cross"] * R.ay, L["ky"] * R.ay - L["cross"] * R.ax])
    elif name == "hold_current":
        z = np.where(R.still, L["rest"] + (1 - L["rest"]) * np.exp(-R.since / L["tau"]), 1.)
        A.dp += s * L["dc"][:, None] * z
        A.off += s * L["off"][:, None] * z
    else:
        raise KeyError(name)


# ------------------------------------------------------------------ from plant to counts
def simulate(hw, R, effects, rs, noise=True):
    """effects: list of (name, law, scale); rs: integer seed of this recording"""
    A = Acc(R)
    for name, L, s in effects:
        apply(name, L, s, R, hw, A, np.random.default_rng([rs, zlib.crc32(name.encode())]))
    rn = np.random.default_rng([rs, 7])
    u = R.p + hw["zero"][:, None] + A.dp                       # what the flux pattern says
    ph = F * u
    z = np.exp(1j * ph)
    h3 = (hw["h3"] if A.h3base is None else A.h3base)[:, None] * A.h3
    w = z + h3 * np.exp(-3j * ph)                              # third harmonic, order 4 of the error
    for m, c in A.harm:
        w = w + c[:, None] * np.exp(1j * m * ph)
    w = w * A.amp
    if A.mix is not None:
        X = A.mix @ w
        w = w + (X if A.mixpart == "both" else 1j * X.imag)
    gain, psi = hw["gain"][:, None] + A.gain, hw["psi"][:, None] + A.psi
    c = w.real * (1 - gain / 2)
    s = (w.imag * np.cos(psi) + w.real * np.sin(psi)) * (1 + gain / 2)
    c = c + hw["goff"][0][:, None] + A.off.real
    s = s + hw["goff"][1][:, None] + A.off.imag
    ns, nc = rn.normal(0, 1, (2, 4, R.N))
    out = {}
    sig = np.array([s, c])
    def clip(sig, kinds):
        L, sc = A.clip
        if L["kind"] not in kinds:
            return sig
        lev = 1 - np.clip(L["depth"] * sc * L["spread"], 0, .5)
        for j in range(2):
            for i in range(4):
                if L["ch"][j, i]:
                    v, lv = sig[j, i], lev[j, i]
                    if L["kind"] == "soft":
                        q = v / (1 + (np.abs(v) / lv) ** L["soft"]) ** (1 / L["soft"])
                        sig[j, i] = q if L["side"] == "both" else np.where(v > 0, q, v)
                    else:
                        sig[j, i] = np.minimum(v, lv) if L["side"] == "top" else np.clip(v, -lv, lv)
        return sig
    if A.clip:
        sig = clip(sig, ("hard_amp", "soft"))
    if hw["counts"]:
        sig = sig * hw["A"]
        sig = sig + np.array([A.qadd.imag, A.qadd.real])
        if noise:
            sig = sig + hw["qn"] * np.array([ns, nc])
        if A.clip:
            sig = clip(sig / hw["A"], ("hard_adc",)) * hw["A"]
        out["over"] = float(np.abs(sig).max())
        if noise:
            sig = np.clip(np.rint(sig), -32768, 32767) + 0.0      # no negative zero: atan2(-0, -c) would be a tooth off
        frac = RHO / (2 * np.pi) * np.arctan2(sig[0], sig[1])
        n = np.rint((u - frac) / RHO).astype(int) + A.slip
        out["q"], out["n"] = sig, n
        out["p"] = n * RHO + frac
    else:
        frac = RHO / (2 * np.pi) * np.arctan2(sig[0], sig[1])
        out["p"] = (np.rint((u - frac) / RHO) + A.slip) * RHO + frac + A.padd + (hw["pn"] * ns if noise else 0)
        out["over"] = 0
    if hw["psd"]:
        dt = A.dtc
        x, y, th = R.x + R.vx * dt + R.ax * dt * dt / 2, R.y + R.vy * dt + R.ay * dt * dt / 2, R.th + R.vth * dt + R.ath * dt * dt / 2
        cx, cy = rot(-th, x - hw["o"][0] - A.beacon[0], y - hw["o"][1] - A.beacon[1])
        d = np.array([cx - hw["lx"] + A.dc[0], cy - hw["ly"] + A.dc[1]]) / (hw["h"] * hw["tfs"])
        seen = np.abs(d).max(0) < .8
        d = np.clip(d, -1, 1)
        for fn in A.dfun:
            d = fn(d)
        S = hw["S"]
        e = np.array([S / 2 * (1 + d[0]), S / 2 * (1 - d[0]), S / 2 * (1 + d[1]), S / 2 * (1 - d[1])]) + A.psdadd
        en = rn.normal(0, 1, (4, R.N))
        if noise:
            e = np.clip(np.rint(e + hw["pn_psd"] * en), 0, 32767)
        e = np.where(seen, e, 0)
        out["e"], out["seen"] = e, seen
        with np.errstate(invalid="ignore", divide="ignore"):
            out["d"] = np.where(seen, np.array([(e[0] - e[1]) / (e[0] + e[1]), (e[2] - e[3]) / (e[2] + e[3])]), 0)
    if hw["form"] == "reference":
        out["ref"] = R.x + (rn.normal(0, 20e-9, R.N) if noise else 0)
    out["A"] = A
    return out


# ------------------------------------------------------------------ own small baseline: equations 3, 5, 11
def residual(hw, o, par, jac=False):
    p = o["p"]
    if hw["form"] == "reference":
        i = hw["seg"]
        H = np.array([f(m * F * p[i]) for m in ORD for f in (np.sin, np.cos)])
        g = p[i] + par[:8] @ H + par[8] - o["ref"]
        return {"segment_1": g}, np.vstack([H, np.ones(len(g))]).T if jac else None
    H = np.array([[f(m * F * p[i]) for m in ORD for f in (np.sin, np.cos)] for i in range(4)])
    k = par[:32].reshape(4, 8)
    ph = p + np.einsum("ik,ikn->in", k, H)
    gp = GP @ ph + par[32]
    G = {"g_p": gp}
    J = None
    if jac:
        n = p.shape[1]
        J = [np.zeros((n, len(par)))]
        for i in range(4):
            J[0][:, 8 * i:8 * i + 8] = (GP[i] * H[i]).T
        J[0][:, 32] = 1
    if hw["psd"]:
        m = o["seen"]
        th = (SGN @ ph[:, m]) / (2 * LS) + par[33]
        h, lx, ly, ox, oy = par[34:39]
        d = o["d"][:, m] * hw["tfs"]
        cx, cy = h * d
        C, S = np.cos(th), np.sin(th)
        px, py = (ph[0, m] + ph[2, m]) / 2, (ph[1, m] + ph[3, m]) / 2
        G["g_x"] = -px + C * cx - S * cy - ly * S + lx * C + ox
        G["g_y"] = -py + S * cx + C * cy + ly * C + lx * S + oy
        if jac:
            tx, ty = -S * cx - C * cy - ly * C - lx * S, C * cx - S * cy - ly * S + lx * C
            for nm, tt, isx in (("x", tx, ISX), ("y", ty, ~ISX)):
                j = np.zeros((m.sum(), len(par)))
                for i in range(4):
                    j[:, 8 * i:8 * i + 8] = ((-.5 * isx[i] + tt * SGN[i] / (2 * LS)) * H[i][:, m]).T
                j[:, 33] = tt
                if nm == "x":
                    j[:, 34], j[:, 35], j[:, 36], j[:, 37] = C * d[0] - S * d[1], C, -S, 1
                else:
                    j[:, 34], j[:, 35], j[:, 36], j[:, 38] = S * d[0] + C * d[1], S, C, 1
                J.append(j)
    return G, (np.vstack(J) if jac else None)


def sigmas(hw):
    sp = hw["qn"] / hw["A"] / F if hw["counts"] else hw["pn"]
    if hw["form"] == "reference":
        return {"segment_1": math.hypot(sp, 20e-9)}
    sc = hw["h"] * hw["tfs"] * math.sqrt(2) * hw["pn_psd"] / hw["S"]
    lev = lambda l: math.sqrt(sp * sp / 2 + (sp * l / LS) ** 2 + sc * sc)
    return {"g_p": 2 * sp, "g_x": lev(hw["ly"]), "g_y": lev(hw["lx"])}


def par0(hw):
    if hw["form"] == "reference":
        return np.zeros(9)
    q = np.zeros(39)
    if hw["psd"]:
        q[34:37] = hw["nom"]
        q[37:39] = hw["B"] - np.array(hw["nom"][1:])
    return q


def stack(hw, G):
    sg = sigmas(hw)
    return np.concatenate([G[k] / sg[k] for k in G])


def basis(hw, G, J):
    sg = sigmas(hw)
    Jw = J / np.concatenate([np.full(len(G[k]), sg[k]) for k in G])[:, None]
    n = np.sqrt((Jw ** 2).sum(0))
    n[n == 0] = 1
    w, V = np.linalg.eigh((Jw / n).T @ (Jw / n))
    ok = w > 1e-9 * w[-1]
    return Jw, n, w[ok], V[:, ok]


def fit(hw, o, par, it=4):
    for _ in range(it):
        G, J = residual(hw, o, par, True)
        Jw, n, w, V = basis(hw, G, J)
        par = par - V @ ((V.T @ ((Jw / n).T @ stack(hw, G))) / w) / n
    G, J = residual(hw, o, par, True)
    return par, G, J


class Meter:
    """what an effect by itself adds to each channel's residual once the baseline is calibrated"""
    def __init__(s, hw, R, rs, base=()):
        s.hw, s.R, s.rs = hw, R, rs
        s.o = simulate(hw, R, list(base), rs, noise=False)
        s.par, s.G, J = fit(hw, s.o, par0(hw), 5)
        Jw, n, w, V = basis(hw, s.G, J)
        s.J, s.w, s.V = Jw / n, w, V
        s.seen = s.o.get("seen")

    def __call__(s, eff, moving=False):
        o = simulate(s.hw, s.R, [eff], s.rs, noise=False)
        if s.seen is not None:
            m = s.seen & o["seen"]
            if m.sum() != s.seen.sum():
                return None, o
        G, _ = residual(s.hw, o, s.par)
        D = {k: G[k] - s.G[k] for k in G}
        y = stack(s.hw, D)
        y = y - s.J @ (s.V @ ((s.V.T @ (s.J.T @ y)) / s.w))
        sg = sigmas(s.hw)
        res, a = {}, 0
        for k in D:
            q = y[a:a + len(D[k])] * sg[k]
            a += len(D[k])
            if moving:
                mm = s.R.moving if len(q) == s.R.N else s.R.moving[s.seen]
                q = q[mm] if mm.sum() > 30 else q
            res[k] = float(np.sqrt(np.mean(q ** 2)) / UM)
        return res, o


# ------------------------------------------------------------------ one case
PSD_ONLY = {"psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew", "beacon_knocked", "ambient_light", "etalon_ripple", "abbe_tilt"}


CAP = {"tooth_variation": 5, "axis_skew": 2.2, "magnetised_spot": 10, "hold_current": 8, "velocity_lag": 6, "hysteresis": 4}   # beyond: not physical


def scaled(name, hw, M, r):
    """draw a law and its scale so that the strongest channel gets 0.8 .. 3.9 um"""
    for _ in range(40):
        L = law(name, r, hw)
        mv = name in MOVING
        if name in UNSCALED:
            m, o = M((name, L, 1.), mv)
            if name == "cycle_slip":
                return L, 1., m
            if m and max(m.values()) >= .75 and o["over"] < 32500:
                return L, 1., m
            continue
        lo = 1.5 if (hw["psd"] and name not in PSD_ONLY) else .85
        T = logu(r, lo, 3.9)
        s, hist = 1., []
        for _ in range(9):
            m, o = M((name, L, s), mv)
            if m is None:
                s *= .5
                continue
            q = max(m.values())
            if abs(q / T - 1) < .04:
                break
            if q < 1e-6:
                s *= 2.
                continue
            ex = 1.
            if hist and abs(math.log(s / hist[-1][0])) > 1e-3 and q != hist[-1][1]:
                ex = np.clip(math.log(q / hist[-1][1]) / math.log(s / hist[-1][0]), .6, 4)
            hist.append((s, q))
            s = float(np.clip(s * (T / q) ** (1 / ex), s / 6, s * 6))
            if s > 60 or s < 1e-3:
                break
        if m is None or not .72 < max(m.values()) < 4.05 or o["over"] > 32400:
            continue
        if s > CAP.get(name, 60):
            continue
        if name == "adc_clipping" and L["depth"] * s > .42:
            continue
        if name == "gap_variation" and (np.std(o["A"].gap) > 60e-6 or o["A"].amp.max() > 1.6 or o["A"].amp.min() < .5 or np.ptp(o["A"].amp) < .08):
            continue
        return L, s, m
    return None


def jsonable(v):
    if isinstance(v, dict):
        return {k: jsonable(q) for k, q in v.items()}
    if isinstance(v, (list, tuple)):
        return [jsonable(q) for q in v]
    if isinstance(v, np.ndarray):
        return jsonable(v.tolist())
    if isinstance(v, complex):
        return [v.real, v.imag]
    if isinstance(v, np.generic):
        return jsonable(v.item())
    return v


def write(d, hw, R, o, case):
    os.makedirs(d, exist_ok=True)
    T = ['schema = 1', 'device = "courier %s"' % case, 'source = "plant simulator %s"' % HERE, '', '[geometry]', 'pitch_m = %.6g' % RHO, 'span_m = %.6g' % LS, 'lateral_m = %.6g' % round(hw["lo"], 5)]
    if hw["psd"]:
        T += ['', '[coordination]', 'height_m = %.6g' % hw["nom"][0], 'lever_x_m = %.6g' % hw["nom"][1], 'lever_y_m = %.6g' % hw["nom"][2], 'tan_full_scale = %.6g' % hw["tfs"]]
    T += ['', '[electronics]']
    if hw["counts"]:
        T += ['adc_bits = 16', 'amplitude_counts = %.1f' % hw["A"], 'quadrature_noise_counts = %.1f' % hw["qn"]]
    else:
        T += ['position_noise_m = %.4g' % hw["pn"]]
    if hw["psd"]:
        T += ['psd_sum_counts = %.1f' % hw["S"], 'psd_noise_counts = %.1f' % hw["pn_psd"]]
    open(os.path.join(d, "recording.toml"), "w").write("\n".join(T) + "\n")
    cols = [("t_s", ["%.6f" % v for v in R.t.tolist()]), ("run", R.run.tolist())]
    segs = [hw["seg"]] if hw["form"] == "reference" else range(4)
    ints = lambda a: list(map(str, a.astype(int).tolist()))
    for i in segs:
        if hw["counts"]:
            cols += [("q%ds" % (i + 1), ints(o["q"][0, i])), ("q%dc" % (i + 1), ints(o["q"][1, i])), ("n%d" % (i + 1), ints(o["n"][i]))]
        else:
            cols += [("p%d_m" % (i + 1), ["%.10f" % v for v in o["p"][i].tolist()])]
    if hw["psd"]:
        for k, e in zip(("psd_xp", "psd_xn", "psd_yp", "psd_yn"), o["e"]):
            cols.append((k, ints(e)))
    if hw["temp"]:
        cols.append(("temp_c", ["%.2f" % v for v in (R.temp + np.random.default_rng(R.N).normal(0, .02, R.N)).tolist()]))
    for k, v in (("cmd_x_m", R.cx + o["A"].cmd[0]), ("cmd_y_m", R.cy + o["A"].cmd[1]), ("cmd_theta_rad", R.cth)):
        cols.append((k, ["%.7f" % q for q in v.tolist()]))
    if hw["form"] == "reference":
        cols.append(("ref_x_m", ["%.9f" % q for q in o["ref"].tolist()]))
    with open(os.path.join(d, "samples.csv"), "w") as f:
        f.write(",".join(c[0] for c in cols) + "\n")
        f.write("\n".join(map(",".join, zip(*[c[1] for c in cols]))) + "\n")


def build(seed, kind, names, form, out, case, log):
    for attempt in range(30):
        r = np.random.default_rng(list(seed) + [attempt])
        hw = hardware(r, form)
        if form == "positions" and any(n in BEACON_ONLY or n in PSD_ONLY for n in names):
            hw["psd"] = True
        if "gap_variation" in names:
            hw["A"] = float(round(r.uniform(20000, 21500)))
        if "adc_clipping" not in names and r.random() < .15 and "thermal_drift" not in names:
            hw["temp"] = False
        dT = r.uniform(4, 10) if "thermal_drift" in names else r.uniform(.4, 2.2)
        P = plan(r, hw)
        Rs = [drive(np.random.default_rng(list(seed) + [attempt, 11 + w]), hw, P, w, dT) for w in (0, 1)]
        if not all(3000 <= R.N <= 12000 for R in Rs):
            continue
        rs = [int(r.integers(1 << 30)) for _ in (0, 1)]
        M = Meter(hw, Rs[0], rs[0])
        eff, sizes = [], {}
        for n in names:
            MM = M
            got = scaled(n, hw, MM, r)
            if got is None:
                break
            eff.append((n, got[0], got[1])); sizes[n] = got[2]
        if len(eff) < len(names):
            continue
        os_ = [simulate(hw, R, eff, q) for R, q in zip(Rs, rs)]
        if any(o["over"] > 32700 for o in os_) or (hw["psd"] and any(o["e"].max() > 32700 for o in os_)):
            continue
        # whitened residual after the own baseline, for the log
        wh = []
        for o in os_:
            if "cycle_slip" in names:
                o = dict(o, p=o["p"] - o["A"].slip * RHO)
            _, G, _ = fit(hw, o, par0(hw))
            sg = sigmas(hw)
            wh.append({k: round(float(np.std(G[k]) / sg[k]), 3) for k in G})
        if kind == "none" and max(max(w.values()) for w in wh) > 1.12:
            log("   none: whitened too high %s" % wh)
            continue
        for nm, R, o in zip(("first", "second"), Rs, os_):
            write(os.path.join(out, case, nm), hw, R, o, case)
        eff_l = [(n, L) for n, L, _ in eff]
        lw = {n: dict(jsonable(L), scale=s, adds_um=sizes[n]) for n, L, s in eff}
        if kind == "two":
            lw["each_alone"] = True
        if "cycle_slip" in names:
            lw["slip_from_s"] = [[float(R.t[np.argmax(o["A"].slip[i] != 0)]) for i in dict(eff_l)["cycle_slip"]["seg"]] for R, o in zip(Rs, os_)]
        lw["whitened_after_own_baseline"] = wh
        lw["samples"] = [int(R.N) for R in Rs]
        lw["sigma_um"] = {k: v / UM for k, v in sigmas(hw).items()}
        log("%s %-9s %-9s %-42s N=%s adds=%s wh=%s" % (case, kind, form, "+".join(names), lw["samples"], {n: {k: round(v, 2) for k, v in m.items()} for n, m in sizes.items()}, wh))
        return lw
    return None


def allowed(name, form):
    if name in UNLISTED:
        return {"beacon": "b", "no_beacon": "n", "positions": "p", "reference": "r"}[form] in UNLISTED[name][2]
    if form == "no_beacon":
        return name not in BEACON_ONLY
    if form == "positions":
        return name not in NOT_POSITIONS
    if form == "reference":
        return name in REF_OK
    return True


def draw_set(K):
    r = np.random.default_rng([zlib.crc32(HERE.encode()), K])
    n1, n2, nu = {1: (19, 18, 15), 2: (19, 19, 14), 3: (18, 19, 15)}[K]
    kinds = ["one"] * n1 + ["two"] * n2 + ["none"] * 8 + ["unlisted"] * nu
    forms = ["positions"] * 7 + ["no_beacon"] * 7 + ["reference"] * 3 + ["beacon"] * 43
    r.shuffle(kinds); r.shuffle(forms)
    cases = [dict(kind=k, form=f) for k, f in zip(kinds, forms)]
    rank = {"reference": 0, "no_beacon": 1, "positions": 2, "beacon": 3}
    pool = list(CATALOGUE); r.shuffle(pool)
    if n1 == 18:
        pool.pop()
    for c in sorted((c for c in cases if c["kind"] == "one"), key=lambda c: rank[c["form"]]):
        k = next(n for n in pool if allowed(n, c["form"]))
        pool.remove(k); c["effects"] = [k]
    un = list(UNLISTED)
    off = [0, 15, 29][K - 1]
    base = list(np.random.default_rng(zlib.crc32(HERE.encode())).permutation(un))
    pool = [str(base[(off + i) % len(base)]) for i in range(nu)]
    for c in sorted((c for c in cases if c["kind"] == "unlisted"), key=lambda c: rank[c["form"]]):
        k = next(n for n in pool if allowed(n, c["form"]))
        pool.remove(k); c["effects"] = [k]
    for c in cases:
        if c["kind"] == "none":
            c["effects"] = []
        if c["kind"] == "two":
            ok = [n for n in CATALOGUE if allowed(n, c["form"])]
            while True:
                e = [str(v) for v in r.choice(ok, 2, replace=False)]
                if set(e) != {"excess_noise", "outlier_bursts"}:
                    break
            c["effects"] = e
    return cases, int(r.integers(1 << 30))


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--set", type=int, required=True, choices=(1, 2, 3))
    ap.add_argument("--out", required=True)
    ap.add_argument("--only", type=int, nargs="*")
    a = ap.parse_args()
    os.makedirs(a.out, exist_ok=True)
    cases, seed = draw_set(a.set)
    truth = []
    lf = open(os.path.join(a.out, "..", "log_%d.txt" % a.set) if False else os.path.join(os.path.dirname(os.path.abspath(__file__)), "log_%d.txt" % a.set), "w")
    def log(s):
        lf.write(s + "\n"); lf.flush()
    for i, c in enumerate(cases):
        if a.only and i not in a.only:
            continue
        case = "c%03d" % i
        lw, sub = None, 0
        while lw is None:
            lw = build([seed, i, sub], c["kind"], c["effects"], c["form"], a.out, case, log)
            sub += 1
            if lw is None:
                log("%s could not be drawn: %s %s" % (case, c["form"], c["effects"]))
                if sub > 2 and c["kind"] == "two":
                    rr = np.random.default_rng([seed, i, sub, 5])
                    while True:
                        e = [str(v) for v in rr.choice([n for n in CATALOGUE if allowed(n, c["form"])], 2, replace=False)]
                        if set(e) != {"excess_noise", "outlier_bursts"}:
                            break
                    c["effects"] = e
                elif sub > 3:
                    raise SystemExit("cannot draw %s" % c)
        u = c["effects"][0] if c["kind"] == "unlisted" else None
        truth.append(dict(case=case, kind=c["kind"], effects=[] if u else c["effects"], unlisted=("%s: %s" % (u, UNLISTED[u][0])) if u else None,
                          places=UNLISTED[u][1] if u else [], form=c["form"], law=lw))
        json.dump(truth, open(os.path.join(a.out, "truth.json"), "w"), indent=1)


if __name__ == "__main__":
    main()
