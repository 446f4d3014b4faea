#!/usr/bin/env python3
"""Independent simulator of a courier's position sensors: recordings with one hidden effect each."""
import os
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import sys, json, argparse, itertools
import numpy as np

RHO = 1.016e-3
UM = 1e-6
SG = [1, 1, -1, -1]                     # sign of span/2*theta in segments 1..4 (1,3: x; 2,4: y)
LAT = [-1, 1, 1, -1]                    # sign of l_o*theta in the lateral coordinate (equation 9)
NAMES = ["lateral_dependence", "extra_harmonics", "tooth_variation", "angle_dependence", "psd_nonlinearity",
         "psd_misalignment", "thermal_drift", "velocity_lag", "psd_latency", "hysteresis", "gap_variation",
         "beacon_vibration", "axis_skew", "cycle_slip", "outlier_bursts", "excess_noise", "adc_clipping",
         "quadrature_drift", "span_error"]
NEED_DIODE = {"lateral_dependence", "psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew"}
NEED_COUNTS = {"gap_variation", "adc_clipping"}
NOT_REF = NEED_DIODE | {"angle_dependence", "span_error"}
NO_RMS = {"cycle_slip", "outlier_bursts", "excess_noise"}
O, L, TH, PL, DE, SP, DI, TI, FR, AM = ("own tooth phase", "lateral tooth phase", "theta|angle", "place|platen", "deflection",
                                        "speed", "direction", "time", "frequency|vibration", "amplitude")
# name: (description, forms: b beacon, n nobeacon, p positions without diode, P positions with diode, r reference, places)
UNL = {
    "u_hum": ("mains (or traction) hum induced in a segment's amplifier", "bnpPr", [TI, FR, O]),
    "u_segx": ("crosstalk of one segment's channels into a segment of the other axis", "bP", [O, L]),
    "u_quant": ("low bits lost: converter (or position word) truncated to coarse steps", "bnpPr", [O, AM, PL]),
    "u_turb": ("hot-air plume in the beacon's light path: slow wander of the apparent beacon", "bP", [TI, FR]),
    "u_redock": ("overhead robot re-docks between runs and its beacon slips by some um at moments", "bP", [TI]),
    "u_height": ("overhead robot's vertical axis sags and creeps: height of the beacon changes in time", "bP", [DE, TI]),
    "u_dark": ("dark-current offset of an electrode while the beacon's brightness changes in time", "bP", [TI, DE, AM]),
    "u_lamp": ("stray lamp switched on and off: second light spot on the diode", "bP", [TI, DE, AM]),
    "u_loose": ("loose segment jumps between two seats some um apart at random moments", "bnpPr", [TI]),
    "u_popcorn": ("popcorn (random telegraph) noise of an electrode's amplifier", "bP", [TI, FR, DE]),
    "u_cable": ("cable goes taut and bends the diode's mast beyond some angle", "bP", [TH]),
    "u_glint": ("specular glint on the diode at some courier angles only", "bP", [TH, DE]),
    "u_pitch": ("courier pitches on its air film under acceleration and tilts the diode's mast", "bP", [TI, SP, DI, DE, PL, FR]),
    "u_psdx": ("diode's electrode signal leaks into a segment's channel while the beacon is seen", "bP", [DE, O, AM]),
    "u_motor": ("motor supply's return current shifts a segment amplifier's ground: order-1 error with effort", "bnpPr", [SP, O, TI]),
    "u_jitter": ("sampling clock of one segment jitters: noise in proportion to speed", "bnpPr", [SP]),
    "u_flex": ("segment's board flexes under acceleration", "bnpPr", [TI, SP, DI, PL, FR]),
}
DIODE_ONLY_SIG = {"u_turb", "u_redock", "u_height", "u_dark", "u_lamp", "u_popcorn", "u_cable", "u_glint", "u_pitch"}
CAP = {"lateral_dependence": 14., "extra_harmonics": .07, "tooth_variation": 40., "angle_dependence": 25., "psd_nonlinearity": .5,
       "psd_misalignment": .12, "thermal_drift": 2.5, "velocity_lag": 3e-3, "psd_latency": 6e-3, "hysteresis": 25.,
       "gap_variation": .12, "beacon_vibration": 30., "axis_skew": .02, "adc_clipping": .4, "quadrature_drift": .12,
       "span_error": 1.6e-3, "u_hum": .12, "u_segx": .12, "u_turb": 40., "u_redock": 40., "u_height": 6e-4, "u_dark": 3000.,
       "u_lamp": .25, "u_loose": 30., "u_popcorn": 400., "u_cable": 80., "u_glint": .3, "u_pitch": 150., "u_psdx": .2,
       "u_motor": .15, "u_jitter": 1e-3, "u_flex": 90.}


def U(r, a, b, size=None):
    return r.uniform(a, b, size)


def logu(r, a, b):
    return float(np.exp(r.uniform(np.log(a), np.log(b))))


# ---------------------------------------------------------------- courses in time
def course(kind, t, tend, seed, tau):
    """zero-mean, about unit rms course over 0..tend, evaluated at t; same seed, same course"""
    r = np.random.default_rng(seed)
    if kind == "telegraph":
        sw = np.cumsum(r.exponential(tau, int(tend / tau * 3) + 20))
        return np.where((np.searchsorted(sw, t) + r.integers(2)) % 2 == 0, 1.0, -1.0)
    n = int(min(max(tend / tau * 12, 200), 60000))
    g = np.linspace(0, tend, n)
    dt = g[1] - g[0]
    if kind == "ou":
        w = r.standard_normal(n + 400)
        a = np.exp(-dt / tau)
        k = a ** np.arange(400)
        y = np.convolve(w, k)[400:400 + n]
        y = np.convolve(np.pad(y, 4, mode="edge"), np.ones(9) / 9, "valid")
    elif kind == "steps":
        m = max(2, int(r.poisson(tend / tau)))
        at = np.sort(r.uniform(0.05 * tend, 0.95 * tend, m))
        y = np.concatenate([[0], np.cumsum(r.standard_normal(m))])[np.searchsorted(at, g)]
        y = y - .4 * np.sign(y) * (np.abs(y) > 2)
    elif kind == "sine":
        T = tend / r.uniform(2.2, 5.5)
        ph = r.uniform(0, 6.28)
        y = np.sin(2 * np.pi * g / T + ph + .5 * np.sin(2 * np.pi * g / tend + ph)) + .3 * np.sin(2 * np.pi * g / T * 2.3 + 2 * ph)
    else:                                # relax: settles, then is disturbed again
        y = np.zeros(n)
        for at in np.concatenate([[0], np.sort(r.uniform(.2, .85, r.integers(1, 3))) * tend]):
            y += r.choice([-1, 1]) * np.where(g >= at, np.exp(-(g - at) / (tend * r.uniform(.06, .2))), 0)
    y = y - y.mean()
    y /= max(y.std(), 1e-9)
    return np.interp(t, g, y)


# ---------------------------------------------------------------- motion
def prof(t, length, v, ta):
    """distance along a pass with sin^2 velocity ramps"""
    T = length / v + ta
    t = np.clip(t, 0, T)
    I = lambda u: u / 2 - np.sin(np.pi * u) / (2 * np.pi)
    return np.where(t < ta, v * ta * I(np.minimum(t / ta, 1)),
                    np.where(t > T - ta, length - v * ta * I(np.clip((T - t) / ta, 0, 1)), v * (t - ta / 2)))


class Motion:
    pass


def make_motion(r, hw, form, diode, need, seed):
    m = Motion()
    m.seed = seed
    blocks = []                          # (run, duration, times rel., f(t)->(x,y,th) or arrays)
    ref = form == "reference"
    x0, y0 = hw["scat"]
    bx, by = hw["o"]
    lx, ly = hw["l"]
    fs = U(r, 700, 1300) * hw.get("fsk", 1.)
    opt = hw["opt"]
    wv = lambda f: hw["acc"] / (2 * np.pi * f) ** 2
    thr = np.radians(U(r, .45, .6)) if form == "beacon" or diode else np.radians(U(r, .8, 1.3))

    def path(run, T, f, lead=None):
        lead = U(r, .02, .06) if lead is None else lead
        ts = np.arange(0, T + 2 * lead, 1 / fs)
        blocks.append((run, T + 2 * lead, ts, (lambda t, f=f, lead=lead: f(t - lead))))

    def stills(run, X, Y, T_, dt):
        n = len(X)
        rep = 1 if n > 350 else 2
        ts = np.cumsum(U(r, .7, 1.3, n) * dt)
        ts = (ts[:, None] + np.arange(rep) / fs).ravel()
        blocks.append((run, ts[-1] + dt, ts, [np.repeat(a, rep) for a in (X, Y, T_)]))

    def beac(cx, cy, th):                # pose of the platen sensor that puts the diode at c
        co, si = np.cos(th), np.sin(th)
        return bx + co * (cx + lx) - si * (cy + ly), by + si * (cx + lx) + co * (cy + ly), th

    def fly(run, axis, sign, Lf, v, th0, lat, slope):
        ta = U(r, .06, .14)
        wob, ph = (0. if ref else U(r, 0, 8e-4)), U(r, 0, 6)

        def f(t):
            s = prof(t, Lf, v, ta) - Lf / 2
            s = s * sign
            th = th0 + wob * np.sin(2 * np.pi * s / .023 + ph)
            q = lat + slope * s
            return (x0 + s, y0 + q, th) if axis == 0 else (x0 + q, y0 + s, th)
        path(run, Lf / v + ta, f)

    if ref:
        Lf = U(r, 42e-3, 60e-3)
        n = r.integers(500, 900)
        X = x0 + U(r, -.5, .5, n) * Lf
        if r.random() < .4:
            X = np.sort(X)[::r.choice([-1, 1])]
        stills("still_poses", X, y0 + 0 * X, 0 * X, U(r, .15, .5))
        sp = [U(r, 45, 80) * 1e-3, U(r, 20, 35) * 1e-3] + ([U(r, 100, 160) * 1e-3] if r.random() < .5 else [])
        for v in sp:
            for s, nm in ((1, ""), (-1, "_back")):
                fly("pass_%d%s" % (round(v * 1e3), nm), 0, s, Lf, v, 0., U(r, -1, 1) * 2e-4, 0.)
        if need or opt[0] < .5:
            f0 = U(r, 1.7, 3.2)
            A = wv(f0)
            path("weave", 1.6, lambda t: (x0 + A * np.sin(2 * np.pi * f0 * t), y0 + 0 * t, 0 * t))
    else:
        n = r.integers(450, 850)
        R = 10 * RHO
        mode = r.integers(3)
        if mode == 0:
            q = U(r, -.5, .5, (n, 3))
        elif mode == 1:                  # additive recurrence
            q = (np.arange(n)[:, None] * np.array([.8191725134, .6710436067, .5497004779]) + r.random(3)) % 1 - .5
        else:                            # lawn mower with jitter, angle at random
            k = int(np.sqrt(n))
            n = k * k
            a, b = np.divmod(np.arange(n), k)
            b = np.where(a % 2, k - 1 - b, b)
            q = np.stack([(b + r.random(n)) / k - .5, (a + r.random(n)) / k - .5, r.random(n) - .5], 1)
        stills("scatter", x0 + R * q[:, 0], y0 + R * q[:, 1], 2 * thr * q[:, 2], U(r, .2, .6))
        v = hw["vf"] * U(r, .92, 1.08)
        vs = hw["vf"] * U(r, .3, .42)
        Lf = U(r, 36e-3, 44e-3)
        for ax, nm in ((0, "flyby_x"), (1, "flyby_y")):
            lat, slope = U(r, -3, 3) * 1e-3, U(r, -.07, .07)
            for s, b in ((1, ""), (-1, "_back")):
                fly(nm + b, ax, s, Lf, v, U(r, -1, 1) * thr * .6, lat, slope)
        both = opt[1] < .3
        for ax, nm in ((0, "flyby_x_slow"), (1, "flyby_y_slow")):
            if ax == 1 or both or need:
                fly(nm, ax, r.choice([-1, 1]), Lf * U(r, .6, .9), vs, U(r, -1, 1) * thr * .6, U(r, -3, 3) * 1e-3, U(r, -.07, .07))
        if form != "beacon" and not diode or r.random() < .3:      # a turning run away from the beacon
            A, T = np.radians(U(r, 1., 1.3)), U(r, .9, 1.6)
            vx = U(r, -1, 1) * 2e-3
            path("spin" if not diode else "turn", T, lambda t: (x0 + vx * t, y0 - vx * t * .6, A * np.sin(2 * np.pi * np.clip(t, 0, T) / T) ** 3))
        if need or opt[2] < .45:
            f0, k = U(r, 1.6, 3.), U(r, .65, .8)
            A = wv(f0)
            a0 = U(r, -1, 1) * thr * .5
            path("weave", 1.5, lambda t: (x0 + A * np.sin(2 * np.pi * f0 * t), y0 + A * np.sin(2 * np.pi * f0 * k * t + 1), a0 + 0 * t))
        if diode:
            n = r.integers(450, 800)
            th = np.radians(1.5) * U(r, -1, 1, n)
            stills("beacon", *beac(RHO * U(r, -1, 1, n), RHO * U(r, -1, 1, n), th), U(r, .2, .6))
            vb = hw["vb"]*U(r, .93, 1.07)
            passes = [("beacon_x", 0, vb), ("beacon_y", 1, vb)]
            if opt[3] < .4:
                passes += [("beacon_x_fast", 0, 2.2 * vb)]
            for nm, ax, vv in passes:
                lat = U(r, -1, 1) * .8e-3
                th0 = np.radians(U(r, -.8, .8))
                for s, b in ((1, ""), (-1, "_back")):
                    ta, wob = U(r, .04, .1), U(r, 0, 4e-4)

                    def f(t, s=s, ta=ta, ax=ax, lat=lat, th0=th0, wob=wob, vv=vv):
                        q = s * (prof(t, 8e-3, vv, ta) - 4e-3)
                        th = th0 + wob * np.sin(q / 1.3e-3)
                        return beac(q, lat + 0 * q, th) if ax == 0 else beac(lat + 0 * q, q, th)
                    path(nm + b, 8e-3 / vv + ta, f)
            T, A = U(r, .8, 1.4), np.radians(U(r, 1.1, 1.35))
            c0 = U(r, -1, 1, 2) * .4e-3
            path("spin", T, lambda t: beac(c0[0] + 0 * t, c0[1] + 0 * t, A * np.sin(2 * np.pi * np.clip(t, 0, T) / T) ** 3))
            if need or opt[4] < .45:
                f2 = U(r, 2.1, 3.2)
                A2 = min(wv(f2), 2.6e-3)
                path("beacon_weave", 1.3, lambda t: beac(A2 * np.sin(2 * np.pi * f2 * t), A2 * np.sin(2 * np.pi * f2 * .62 * t + 2), .004 + 0 * t))
        if r.random() < .8:
            p = beac(U(r, -1, 1) * 1e-3, U(r, -1, 1) * 1e-3, U(r, -1, 1) * .01) if diode and r.random() < .6 else \
                (x0 + U(r, -4, 4) * 1e-3, y0 + U(r, -4, 4) * 1e-3, U(r, -1, 1) * .005)
            under = abs(p[0] - x0) > 9e-3
            path("still_beacon" if under else "still", U(r, .2, .4), lambda t: (p[0] + 0 * t, p[1] + 0 * t, p[2] + 0 * t))
    # order: still poses first or last or split, the rest shuffled, backs stay behind their forward pass
    idx = list(range(len(blocks)))
    groups, i = [], 0
    while i < len(idx):
        g = [i]
        while i + 1 < len(idx) and blocks[i + 1][0].endswith("_back"):
            i += 1
            g.append(i)
        groups.append(g)
        i += 1
    r.shuffle(groups)
    T0 = U(r, 0, 30)
    t_, run, X, V, Ac, path_id, tstart = [], [], [], [], [], [], []
    fns, tb = [], 0.
    for g in groups:
        for bi in g:
            nm, dur, ts, f = blocks[bi]
            t = tb + ts
            e = 2e-4
            if callable(f):
                a, b, c = (np.stack(f(ts + d)) for d in (-e, 0., e))
                X.append(b); V.append((c - a) / (2 * e)); Ac.append((c - 2 * b + a) / e ** 2)
                fns.append((f, tb))
                path_id += [len(fns) - 1] * len(ts)
            else:
                X.append(np.stack(f)); V.append(np.zeros((3, len(ts)))); Ac.append(np.zeros((3, len(ts))))
                path_id += [-1] * len(ts)
            t_.append(t)
            run += [nm] * len(ts)
            tstart += [tb] * len(ts)
            tb += dur + U(r, .8, 9.)
    m.t = np.concatenate(t_)
    m.run = np.array(run)
    m.X, m.V, m.A = (np.concatenate(a, 1) for a in (X, V, Ac))
    m.pid, m.fns, m.tend, m.T0, m.fs = np.array(path_id), fns, m.t[-1] + 1, T0, fs
    m.tstart = np.array(tstart)
    m.n = m.nfull = len(m.t)
    m.idx = np.arange(m.n)
    m.full = m
    m.see = np.array([("beacon" in a) or (a == "spin" and diode) for a in run]) & diode
    return m


def sub(m, k):
    s = Motion()
    s.__dict__.update(m.__dict__)
    s.idx = np.arange(0, m.n, k)
    for a in ("t", "run", "pid", "see", "tstart"):
        setattr(s, a, getattr(m, a)[s.idx])
    s.X, s.V, s.A = m.X[:, s.idx], m.V[:, s.idx], m.A[:, s.idx]
    s.Tk = m.Tk[s.idx] if hasattr(m, "Tk") else None
    s.n = len(s.idx)
    s.full = m
    return s


def pose(m, dt):
    if np.isscalar(dt) and dt == 0:
        return m.X
    out = m.X.copy()
    dt = np.broadcast_to(dt, m.t.shape)
    for k, (f, tb) in enumerate(m.fns):
        j = np.flatnonzero(m.pid == k)
        if len(j):
            out[:, j] = np.stack(f(m.t[j] - tb + dt[j]))
    return out


# ---------------------------------------------------------------- hardware
def make_hw(r, form, names):
    hw = dict(ls=U(r, 8.6e-3, 11.5e-3), seed=int(r.integers(1 << 30)))
    if r.random() < .4:
        hw["ls"] = 9.7e-3
    lo = U(r, 2.8e-3, 8e-3)
    while abs(lo - hw["ls"] / 2) < .7e-3:
        lo = U(r, 2.8e-3, 8e-3)
    hw["lo"] = lo
    hw["ls"], hw["lo"] = round(hw["ls"], 5), round(lo, 5)
    dl = U(r, -1, 1) * 3e-6
    hw["span_t"] = [hw["ls"] + dl + U(r, -.6, .6) * 1e-6 for _ in range(2)]
    hw["h0"] = round(U(r, 45e-3, 66e-3), 4)
    hw["tfs"] = round(U(r, 6.6e-3, 9.5e-3) / hw["h0"], 3)
    hw["h"] = hw["h0"] * (1 + U(r, -.03, .03))
    hw["l0"] = np.round([U(r, 55e-3, 98e-3) * (1 if r.random() < .8 else -1), U(r, -14e-3, 14e-3)], 3)
    hw["l"] = hw["l0"] + np.array([U(r, -2e-3, 2e-3), U(r, -1.2e-3, 1.2e-3)])
    hw["scat"] = (U(r, .06, .3), U(r, .06, .3))
    hw["o"] = np.array(hw["scat"]) + np.array([U(r, .05, .11) * r.choice([-1, 1]), U(r, -.04, .06)]) - hw["l0"]
    hw["amp0"] = float(round(U(r, 20000, 26000), -2))
    if "gap_variation" in names:
        hw["amp0"] = float(round(U(r, 19500, 21500), -2))
    hw["noise"] = round(U(r, 10, 25), 1)
    hw["psum"] = float(round(U(r, 27000, 37000), -2))
    hw["pnoise"] = round(U(r, 1.2, 2.6), 2)
    hw["pos_noise"] = round(logu(r, .1, .3), 3) * UM
    hw["bright"] = U(r, .96, 1.03)
    hw["vb"], hw["vf"] = U(r, 17e-3, 24e-3), U(r, 38e-3, 62e-3)
    hw["opt"], hw["acc"] = r.random(6), U(r, .35, .8)
    hw["seg"] = []
    for i in range(4):
        hw["seg"].append(dict(A=hw["amp0"] * U(r, .92, 1.07), gain=U(r, -.03, .03), psi=np.radians(U(r, -1.3, 1.3)),
                              off=U(r, -.006, .006, 2), a3=U(r, .001, .006), p3=U(r, 0, 6.28), b3=U(r, 0, .003), q3=U(r, 0, 6.28),
                              a2=U(r, 0, .004), p2=U(r, 0, 6.28), a5=U(r, 0, .0012), p5=U(r, 0, 6.28), zero=U(r, -.4, .4) * RHO))
    return hw


def temps(r, m, big):
    rng = U(r, 8.5, 15) if big else U(r, .5, 4)
    kind = r.choice(["warm", "cycle", "updown", "ou"], p=[.15, .3, .3, .25] if big else [.4, .2, .2, .2])
    u = m.t / m.tend
    if kind == "warm":
        y = 1 - np.exp(-u / U(r, .15, .5))
    elif kind == "cycle":
        y = np.sin(2 * np.pi * u * U(r, 1.2, 3.2) + U(r, 0, 6)) + .5 * u
    elif kind == "updown":
        k = U(r, .3, .7)
        y = np.where(u < k, 1 - np.exp(-u / k * 2.5), (1 - np.exp(-2.5)) * np.exp(-(u - k) / U(r, .12, .35)))
    else:
        y = course("ou", m.t, m.tend, int(r.integers(1 << 30)), m.tend * U(r, .1, .25))
    y = (y - y.min()) / np.ptp(y)
    if r.random() < .3:
        y = 1 - y
    m.Tk = U(r, 20, 27) + rng * y
    m.temp_log = np.round(m.Tk + .03 * r.standard_normal(m.n), 2)


# ---------------------------------------------------------------- effects: drawing of parameters
def pick(r, lo, hi, pool=4):
    k = int(r.integers(lo, hi + 1))
    w = np.zeros(4)
    j = r.permutation(pool)[:k] if pool > 1 else [0]
    w[j] = U(r, .4, 1, len(j)) * r.choice([-1, 1], len(j))
    return w / np.abs(w).max()


def draw(r, name, hw, form):
    ns = 1 if form == "reference" else 4
    P = dict(seed=int(r.integers(1 << 30)))
    if name == "lateral_dependence":
        w = np.abs(pick(r, 2, 4, ns))
        P.update(w=w, ph=U(r, 0, 6.28, 4), a2=U(r, 0, .8, 4), ph2=U(r, 0, 6.28, 4), bend=U(r, 0, .35), leak=U(r, 0, .15))
    elif name == "extra_harmonics":
        pool = [-2, 4, 6, -4, 8, -6, -9]
        P.update(w=np.abs(pick(r, 1, 4, ns)), h=[[(int(m), U(r, .3, 1), U(r, 0, 6.28)) for m in r.choice(pool, r.integers(1, 4), replace=False)] for _ in range(4)])
    elif name == "tooth_variation":
        P.update(own=r.integers(3, 8), lat=r.integers(2, 7), neigh=U(r, 0, .5), sparse=r.random() < .35, taper=U(r, .3, 1.))
    elif name == "angle_dependence":
        P.update(w=pick(r, 1, 4, ns), q=U(r, .3, 1, 4), off=U(r, -1, 1, 4) * U(r, 0, .8), oph=U(r, 0, 6.28, 4), th3=U(r, -1, 1, 4) * U(r, 0, .6), cur=U(r, -.5, .5))
    elif name == "psd_nonlinearity":
        P.update(k3=U(r, -1, 1, 2), cross3=U(r, .2, 1.3, 2), k2=U(r, -.6, .6, 2), xy=U(r, -.7, .7, 2), fifth=U(r, -.5, .5))
        if max(abs(P["k3"])) < .5:
            P["k3"] = r.choice([-1, 1], 2) * U(r, .5, 1, 2)
    elif name == "psd_misalignment":
        P.update(sgn=r.choice([-1, 1]), turn=U(r, -.02, .02) * (r.random() < .6))
    elif name == "thermal_drift":
        P.update(c=U(r, -1, 1, 4), alpha=U(r, 8e-6, 24e-6), lag=U(r, .0, 8.))
        P["c"][0] = U(r, .5, 1) * r.choice([-1, 1])
        P["alpha_rel"] = P["alpha"] if form == "reference" else U(r, 0, 1) * 1e-5
    elif name == "velocity_lag":
        P.update(w=np.abs(pick(r, 1, 3, ns)) * r.choice([1, 1, 1]), kind=r.choice(["delay", "eddy", "filter"]), v0=U(r, .03, .09))
    elif name == "psd_latency":
        P.update(sgn=r.choice([-1, 1]), per=U(r, .9, 1.1))
    elif name == "hysteresis":
        P.update(w=pick(r, 1, 4, ns), lam=logu(r, 8e-6, 1.2e-4))
    elif name == "gap_variation":
        kx = [(U(r, -1, 1, 2) * 2 * np.pi / logu(r, 14e-3, 60e-3), U(r, 0, 6.28), U(r, .4, 1)) for _ in range(4)]
        P.update(k=kx, depth=U(r, 15e-6, 38e-6), tilt=U(r, -1, 1, 2) * 2e-4, w=np.abs(pick(r, 2, 4, ns)), ph=U(r, 0, 6.28, 4), h3=U(r, 0, .8, 4), p3=U(r, 0, 6.28, 4))
    elif name == "beacon_vibration":
        n = r.integers(1, 4)
        P.update(f=[logu(r, 12, 190) for _ in range(n)], a=U(r, .4, 1, (n, 2)) * r.choice([-1, 1], (n, 2)), d=U(r, 0, 6.28, n), am=U(r, 0, .3), one=r.random() < .3)
    elif name == "axis_skew":
        P.update(e=U(r, -1, 1), g=U(r, -1, 1))
        if abs(P["e"]) < .3 and abs(P["g"]) < .3:
            P["g"] = .8
    elif name == "cycle_slip":
        P.update(seg=int(r.integers(ns)), k=int(r.choice([-3, -2, -1, 1, 2, 3], p=[.06, .12, .32, .32, .12, .06])))
    elif name == "outlier_bursts":
        tgt = "q" if not hw["diode"] or r.random() < .7 else "psd"
        P.update(frac=logu(r, .003, .03), lo=U(r, 15, 40), hi=U(r, 60, 200), len=r.integers(2, 18), tgt=tgt, segs=r.permutation(ns)[:r.integers(1, ns + 1)], ring=r.random() < .5)
    elif name == "excess_noise":
        P.update(f=logu(r, 1.6, 6.), q=True, psd=r.random() < .4)
        if hw["diode"] and r.random() < .2:
            P.update(q=False, psd=True)
    elif name == "adc_clipping":
        P.update(w=np.abs(pick(r, 1, 3, ns)), both=r.random() < .6, knee=logu(r, .002, .03), asym=U(r, -.4, .4) * (r.random() < .4))
    elif name == "quadrature_drift":
        P.update(w=pick(r, 1, 3, ns), mix=U(r, .0, 1, (4, 4)), kind=str(r.choice(["ou", "steps", "sine", "relax"])), tau=U(r, .05, .2))
        P["mix"][np.arange(4), r.integers(0, 4, 4)] = 1.3
    elif name == "span_error":
        P.update(w=U(r, -1, 1, 2), lo=U(r, -.5, .5))
        while abs(P["w"][0] - P["w"][1]) < .7:
            P["w"] = U(r, -1, 1, 2)
    # ---- causes outside the catalogue
    elif name == "u_hum":
        P.update(w=np.abs(pick(r, 1, 3, ns)), f=float(r.choice([50, 60, 16.7])) * U(r, .999, 1.001), h3=U(r, 0, .5), pol=U(r, 0, 6.28, (4, 2)), a=U(r, .3, 1, (4, 2)))
    elif name == "u_segx":
        j = int(r.integers(4))
        P.update(to=j, fr=int((j + r.choice([1, 3])) % 4), ph=U(r, 0, 6.28), back=U(r, 0, 1) * (r.random() < .5))
    elif name == "u_quant":
        P.update(segs=r.permutation(ns)[:r.integers(1, ns + 1)])
    elif name == "u_turb":
        P.update(t1=U(r, 2, 9), t2=U(r, .15, .5), mix=U(r, .2, .7), asp=U(r, .5, 1.5))
    elif name == "u_redock":
        P.update(dir=U(r, 0, 6.28), slip=U(r, .3, 1.))
    elif name == "u_height":
        P.update(kind=str(r.choice(["sine", "relax", "ou"])), tau=U(r, .08, .2))
    elif name == "u_dark":
        P.update(e=int(r.integers(4)), e2=int(r.integers(4)), kind=str(r.choice(["sine", "relax", "ou"])), dep=U(r, .18, .3))
    elif name == "u_lamp":
        P.update(at=U(r, .3, .85, 2) * r.choice([-1, 1], 2), tau=U(r, 25, 80))
    elif name == "u_loose":
        P.update(seg=int(r.integers(ns)), tau=U(r, 5, 40))
    elif name == "u_popcorn":
        P.update(e=int(r.integers(4)), tau=logu(r, .08, 3.))
    elif name == "u_cable":
        P.update(th0=np.radians(U(r, -.5, .6)), w=np.radians(U(r, .03, .2)), dir=U(r, 0, 6.28), side=r.choice([-1, 1]))
    elif name == "u_glint":
        P.update(th0=np.radians(U(r, -.9, .9)), w=np.radians(U(r, .12, .35)), at=U(r, .3, .9, 2) * r.choice([-1, 1], 2))
    elif name == "u_pitch":
        P.update(k=U(r, .5, 1, 2) * r.choice([-1, 1]))
    elif name == "u_psdx":
        P.update(seg=int(r.integers(4)), e=int(r.integers(4)), ph=U(r, 0, 6.28))
    elif name == "u_motor":
        P.update(w=np.abs(pick(r, 1, 2, ns)), ph=U(r, 0, 6.28, 4), ka=U(r, .2, 1), kv=U(r, .4, 1.))
    elif name == "u_jitter":
        P.update(seg=int(r.integers(ns)))
    elif name == "u_flex":
        P.update(w=pick(r, 1, 2, ns))
    return P


def tooth_field(P):
    """two displacement fields (x, y) of a platen of 256 x 256 tooth posts, as a segment of own x lat teeth feels them, in units of one tooth's rms"""
    if "F" in P:
        return P["F"]
    r = np.random.default_rng(P["seed"])
    N, os_ = 256, 4
    out = []
    for ax in range(2):
        D = r.standard_normal((N, N))
        if P["sparse"]:
            D *= (r.random((N, N)) < .12) * 2.6
        D = D + P["neigh"] * .5 * sum(np.roll(D, s, a) for s in (-1, 1) for a in (0, 1))     # a misplaced tooth has neighbours
        big = np.zeros((N * os_, N * os_))
        big[::os_, ::os_] = D
        u = np.arange(N * os_)
        u = np.minimum(u, N * os_ - u) / os_

        def ker(n):
            e = P["taper"]
            k = np.clip((n / 2 + e / 2 - u) / e, 0, 1)
            return k / (k.sum() / os_)
        ka, kb = (ker(P["own"]), ker(P["lat"])) if ax == 0 else (ker(P["lat"]), ker(P["own"]))
        F = np.fft.irfft2(np.fft.rfft2(big) * np.fft.fft(ka)[:, None] * np.fft.rfft(kb)[None, :], s=big.shape)
        out.append(F)
    P["F"] = out
    return out


def field_at(F, x, y):
    n = F.shape[0]
    a, b = x / RHO * 4, y / RHO * 4
    ia, ib = np.floor(a).astype(int), np.floor(b).astype(int)
    fa, fb = a - ia, b - ib
    fa, fb = fa * fa * (3 - 2 * fa), fb * fb * (3 - 2 * fb)
    g = lambda i, j: F[i % n, j % n]
    return (g(ia, ib) * (1 - fa) * (1 - fb) + g(ia + 1, ib) * fa * (1 - fb) + g(ia, ib + 1) * (1 - fa) * fb + g(ia + 1, ib + 1) * fa * fb)


def hyst_state(P, m, own_full, i):
    key = ("hs", id(m.full), i)
    if key not in P:
        h, st, lam = 0., np.empty(len(own_full)), P["lam"]
        du = np.diff(own_full, prepend=own_full[0] - 1e-3 * (1 if P["seed"] % 2 else -1))
        ex = np.exp(-np.abs(du) / lam)
        sg = np.sign(du)
        for k in range(len(st)):
            if sg[k]:
                h = sg[k] - (sg[k] - h) * ex[k]
            st[k] = h
        P[key] = st
    return P[key]


# ---------------------------------------------------------------- the plant
def simulate(hw, m, eff, form, rng=None):
    """eff: {name: (strength, params)}. rng None: no noise, no rounding. Returns a dict of channels."""
    ref = form == "reference"
    segs = [0] if ref else [0, 1, 2, 3]
    E = lambda k: eff.get(k, (0., None))
    t = m.t
    n = m.n
    out = {}
    per = lambda tag: np.random.default_rng([m.seed, tag])
    vown = [m.V[0] + hw["ls"] / 2 * m.V[2], m.V[1] + hw["ls"] / 2 * m.V[2], m.V[0] - hw["ls"] / 2 * m.V[2], m.V[1] - hw["ls"] / 2 * m.V[2]]
    aown = [m.A[0] + hw["ls"] / 2 * m.A[2], m.A[1] + hw["ls"] / 2 * m.A[2], m.A[0] - hw["ls"] / 2 * m.A[2], m.A[1] - hw["ls"] / 2 * m.A[2]]
    body = np.array([[-hw["lo"], -hw["ls"] / 2], [hw["ls"] / 2, -hw["lo"]], [hw["lo"], hw["ls"] / 2], [-hw["ls"] / 2, hw["lo"]]])
    span = list(hw["span_t"])
    lo = hw["lo"]
    s, P = E("span_error")
    if P:
        span = [span[0] + s * P["w"][0], span[1] + s * P["w"][1]]
        lo = lo + s * P["lo"]

    # ---------- coordination sensor first (its light may leak)
    el = None
    if hw["diode"]:
        s, P = E("psd_latency")
        X = pose(m, s * P["sgn"] * P["per"] if P else 0.)
        x, y, th = X
        ob = np.array([np.full(n, hw["o"][0]), np.full(n, hw["o"][1])])
        s, P = E("beacon_vibration")
        if P:
            r = per(11)
            for k, f in enumerate(P["f"]):
                ph = r.uniform(0, 6.28)
                env = 1 + P["am"] * np.sin(2 * np.pi * t / r.uniform(3, 12) + ph)
                ob[0] += s * UM * P["a"][k, 0] * env * np.sin(2 * np.pi * f * t + ph)
                if not P["one"]:
                    ob[1] += s * UM * P["a"][k, 1] * env * np.sin(2 * np.pi * f * t + ph + P["d"][k])
        s, P = E("u_redock")
        if P:
            r = per(12)
            for tb in np.unique(m.full.tstart):
                d = r.standard_normal(2) * .7
                ob[:, m.tstart == tb] += s * UM * d[:, None]
            c = course("steps", t, m.tend, [m.seed, 13], m.tend / 5)
            ob += s * UM * P["slip"] * c * np.array([[np.cos(P["dir"])], [np.sin(P["dir"])]])
        s, P = E("u_turb")
        if P:
            for a in range(2):
                ob[a] += s * UM * (P["asp"] if a else 1) * (course("ou", t, m.tend, [m.seed, 14 + a], P["t1"]) + P["mix"] * course("ou", t, m.tend, [m.seed, 16 + a], P["t2"]))
        dx, dy = x - ob[0], y - ob[1]
        co, si = np.cos(th), np.sin(th)
        cx = co * dx + si * dy - hw["l"][0]
        cy = -si * dx + co * dy - hw["l"][1]
        s, P = E("u_pitch")
        if P:
            cx = cx + s * UM * P["k"][0] * (co * m.A[0] + si * m.A[1])
            cy = cy + s * UM * P["k"][1] * (-si * m.A[0] + co * m.A[1])
        s, P = E("u_cable")
        if P:
            q = P["side"] * (th - P["th0"]) / P["w"]
            pull = np.logaddexp(0, q) * P["w"] / .02
            cx = cx + s * UM * pull * np.cos(P["dir"])
            cy = cy + s * UM * pull * np.sin(P["dir"])
        h = np.full(n, hw["h"])
        s, P = E("u_height")
        if P:
            h = h + s * course(P["kind"], t, m.tend, [m.seed, 20], m.tend * P["tau"])
        ux, uy = cx / h / hw["tfs"], cy / h / hw["tfs"]
        s, P = E("psd_misalignment")
        if P:
            ct, st = np.cos(P["turn"]), np.sin(P["turn"])
            ux, uy = (1 + s * P["sgn"] / 2) * (ct * ux - st * uy), (1 - s * P["sgn"] / 2) * (st * ux + ct * uy)
        s, P = E("psd_nonlinearity")
        if P:
            r2x, r2y = ux ** 2 + P["cross3"][0] * uy ** 2, uy ** 2 + P["cross3"][1] * ux ** 2
            ux, uy = (ux + s * (P["k3"][0] * ux * r2x * (1 + P["fifth"] * r2x) + P["k2"][0] * ux ** 2 + P["xy"][0] * ux * uy),
                      uy + s * (P["k3"][1] * uy * r2y * (1 + P["fifth"] * r2y) + P["k2"][1] * uy ** 2 + P["xy"][1] * ux * uy))
        fall = 1 / (1 + (cx ** 2 + cy ** 2) / hw["h"] ** 2) ** 1.5
        I = hw["psum"] * hw["bright"] * fall * (1 + .01 * np.sin(2 * np.pi * t / m.tend * 1.7 + hw["seed"]))
        s, P = E("u_dark")
        if P:
            I = I * (1 - P["dep"] * (.5 + .5 * np.tanh(course(P["kind"], t, m.tend, [m.seed, 21], m.tend * .12))))
        el = [I / 2 * (1 + ux), I / 2 * (1 - ux), I / 2 * (1 + uy), I / 2 * (1 - uy)]
        if P:
            el[P["e"]] = el[P["e"]] + s
            el[P["e2"]] = el[P["e2"]] + .5 * s
        for nm, tag in (("u_lamp", 22), ("u_glint", 23)):
            s, P = E(nm)
            if P:
                if nm == "u_lamp":
                    g = .5 + .5 * course("telegraph", t, m.tend, [m.seed, tag], P["tau"])
                else:
                    g = np.exp(-.5 * ((th - P["th0"]) / P["w"]) ** 2)
                B = s * hw["psum"] * g
                for k, a in enumerate((P["at"][0], -P["at"][0], P["at"][1], -P["at"][1])):
                    el[k] = el[k] + B / 2 * (1 + a)
        s, P = E("u_popcorn")
        if P:
            el[P["e"]] = el[P["e"]] + s * (.5 + .5 * course("telegraph", t, m.tend, [m.seed, 24], P["tau"]))

    # ---------- platen sensor
    own_true = []
    Zs, own = [None] * 4, [None] * 4
    for i in segs:
        dt = 0.
        s, P = E("velocity_lag")
        if P and P["w"][i]:
            tau = s * P["w"][i]
            dt = -tau if P["kind"] == "delay" else (-tau / (1 + (vown[i] / P["v0"]) ** 2) if P["kind"] == "eddy" else -tau + 0 * t)
        s, P = E("u_jitter")
        if P and P["seg"] == i:
            dt = dt + s * per(30).uniform(-1.7, 1.7, m.nfull)[m.idx]
        x, y, th = pose(m, dt)
        ax = i % 2
        u = (y if ax else x) + SG[i] * span[ax] / 2 * th
        w = (x if ax else y) + LAT[i] * lo * th
        px, py = x + body[i, 0], y + body[i, 1]         # place on the platen
        own_true.append(u)
        d = np.zeros(n)
        s, P = E("axis_skew")
        if P and ax == 1:
            d = d + s * P["e"] * (u - hw["scat"][1]) + s * P["g"] * (w - hw["scat"][0])
        s, P = E("tooth_variation")
        if P:
            d = d + s * UM * field_at(tooth_field(P)[ax], px, py)
        s, P = E("lateral_dependence")
        fw = 2 * np.pi * w / RHO
        if P:
            q = fw + P["ph"][i]
            d = d + s * UM * P["w"][i] * (np.sin(q + P["bend"] * np.sin(q)) + P["a2"][i] * .6 * np.sin(2 * fw + P["ph2"][i]))
        s, P = E("hysteresis")
        if P and P["w"][i]:
            F = m.full.X
            st = hyst_state(P, m, F[1 if ax else 0] + SG[i] * hw["ls"] / 2 * F[2], i)[m.idx]
            d = d - s * UM * P["w"][i] * st / 2
        s, P = E("thermal_drift")
        if P:
            key = ("Tb", id(m.full))
            if key not in P:
                tg = np.linspace(0, m.tend, 4000)
                Tg = np.interp(tg, m.full.t, m.full.Tk)
                a = np.exp(-(tg[1] - tg[0]) / max(P["lag"], 1e-3))
                o = np.empty(4000)
                v = Tg[0]
                for k in range(4000):
                    v = a * v + (1 - a) * Tg[k]
                    o[k] = v
                P[key] = np.interp(m.full.t, tg, o)
            dT = P[key][m.idx] - 23.
            d = d + s * UM * P["c"][i] * dT - (P["alpha_rel"] * dT * (u - hw["scat"][ax])) * (s if not ref else min(s * 2, 1))
        s, P = E("u_loose")
        if P and P["seg"] == i:
            d = d + s * UM * .5 * course("telegraph", t, m.tend, [m.seed, 31], P["tau"])
        s, P = E("u_flex")
        if P:
            d = d + s * UM * P["w"][i] * aown[i]
        g = hw["seg"][i]
        ph = 2 * np.pi * (u + d + g["zero"]) / RHO
        own[i] = u + d + g["zero"]
        kk = 2 * np.pi / RHO
        gap = 0.
        sgap, Pg = E("gap_variation")
        if Pg:
            gap = sum(a * np.sin(k[0] * px + k[1] * py + p) for k, p, a in Pg["k"]) / np.sqrt(sum(a * a for _, _, a in Pg["k"]) / 2)
            gap = Pg["depth"] * np.clip(gap, -1.8, 1.8) / 1.3 + Pg["tilt"][0] * (px - hw["scat"][0]) + Pg["tilt"][1] * (py - hw["scat"][1])
            gap = np.clip(gap, -42e-6, 90e-6)
        att = lambda mm: np.exp(-abs(mm) * kk * gap)
        a3, psi = g["a3"], g["psi"]
        z = np.exp(1j * ph) * att(1) + a3 * np.exp(1j * (-3 * ph + g["p3"])) * att(3) + g["b3"] * np.exp(1j * (3 * ph + g["q3"])) * att(3)
        z = z + g["a2"] * np.exp(1j * (2 * ph + g["p2"])) * att(2) + g["a5"] * np.exp(1j * (-5 * ph + g["p5"])) * att(5)
        if Pg:                                   # third harmonic dies faster than the fundamental, stray coupling does not die at all
            z = z + sgap * Pg["w"][i] * (np.exp(1j * Pg["ph"][i]) + Pg["h3"][i] * att(3) * np.exp(1j * (-3 * ph + Pg["p3"][i])))
        s, P = E("extra_harmonics")
        if P and P["w"][i]:
            for mm, a, p in P["h"][i]:
                z = z + s * P["w"][i] * a * np.exp(1j * (mm * ph + p))
        s, P = E("lateral_dependence")
        if P:
            z = z + s * UM * kk * P["leak"] * P["w"][i] * np.exp(1j * P["ph2"][i]) * np.cos(fw + P["ph"][i])
        delta = 0.
        s, P = E("angle_dependence")
        if P and P["w"][i]:                      # sine and cosine coils lie side by side across the teeth, and are long
            b = s * P["w"][i] * (th + P["cur"] * th * np.abs(th) / .02)
            delta = b * P["q"][i] / 2
            z = z + b * P["off"][i] / 2 * np.exp(1j * P["oph"][i]) + b * P["th3"][i] / 2 * np.exp(1j * (-3 * ph + P["p3"] if "p3" in P else -3 * ph))
        gain, off = g["gain"], g["off"][0] + 1j * g["off"][1]
        s, P = E("quadrature_drift")
        if P and P["w"][i]:
            q = [s * P["w"][i] * P["mix"][i][k] * course(P["kind"], t, m.tend, [m.seed, 40 + 4 * i + k], m.tend * P["tau"]) for k in range(4)]
            gain = gain + q[0]
            psi = psi + q[1]
            off = off + .7 * q[2] + .7j * q[3]
        s, P = E("u_motor")
        if P and P["w"][i]:
            I_ = P["ka"] * np.hypot(m.A[0], m.A[1]) / .6 + P["kv"] * np.hypot(m.V[0], m.V[1]) / .05
            off = off + s * P["w"][i] * np.exp(1j * P["ph"][i]) * I_
        s, P = E("u_hum")
        if P and P["w"][i]:
            p0 = per(32).uniform(0, 6.28)
            hum = lambda k: P["a"][i, k] * (np.sin(2 * np.pi * P["f"] * t + p0 + P["pol"][i, k]) + P["h3"] * np.sin(3 * (2 * np.pi * P["f"] * t + p0) + P["pol"][i, k]))
            off = off + s * P["w"][i] * (hum(0) + 1j * hum(1))
        s, P = E("u_psdx")
        if P and P["seg"] == i:
            off = off + s * np.exp(1j * P["ph"]) * np.where(m.see, el[P["e"]], 0) / hw["psum"]
        Zs[i] = (z, gain, psi, off, delta)
    s, P = E("u_segx")
    if P:
        z0 = {j: Zs[j][0] for j in segs}
        a, b = P["to"], P["fr"]
        Zs[a] = (z0[a] + s * np.exp(1j * P["ph"]) * z0[b],) + Zs[a][1:]
        if P["back"]:
            Zs[b] = (z0[b] + s * P["back"] * np.exp(-1j * P["ph"]) * z0[a],) + Zs[b][1:]

    fN, PN = E("excess_noise")
    nq = hw["noise"] * (PN["f"] if PN and PN["q"] else 1)
    npd = hw["pnoise"] * (PN["f"] if PN and PN["psd"] else 1)
    npos = hw["pos_noise"] * (PN["f"] if PN and PN["q"] else 1)
    _, PO = E("outlier_bursts")
    hit = None
    if PO and rng is not None:
        hit = np.zeros(n)
        r = per(50)
        ts = 0
        while ts < PO["frac"] * n:
            k = int(r.integers(n))
            ln = int(r.integers(1, PO["len"] + 1))
            j = np.arange(k, min(n, k + ln))
            a = r.uniform(PO["lo"], PO["hi"]) * r.choice([-1, 1])
            hit[j] = a * (np.exp(-(j - k) / 6.) * np.cos((j - k) * 1.9) if PO["ring"] else r.choice([-1, 1], len(j)) * r.uniform(.6, 1, len(j)))
            ts += len(j)
    out["p"] = [None] * 4
    for i in segs:
        z, gain, psi, off, delta = Zs[i]
        A = hw["seg"][i]["A"]
        c = A * ((1 + gain / 2) * np.real(z * np.exp(-1j * delta)) + np.real(off))
        sn = A * ((1 - gain / 2) * np.imag(z * np.exp(1j * (psi + delta))) + np.imag(off))
        s, P = E("adc_clipping")
        if P and P["w"][i]:
            def clip(v, sh):
                Lc, k = A * (1 - s * P["w"][i]) * (1 + sh), P["knee"] * A
                a = np.abs(v)
                return np.sign(v) * np.where(a < Lc - k, a, Lc - k + k * np.tanh((a - Lc + k) / k))
            lim = lambda v: clip(v, 0.) if not P["asym"] else np.where(v > 0, clip(v, 0.), clip(v, s * P["w"][i] * P["asym"]))
            sn = lim(sn)
            if P["both"]:
                c = lim(c)
        if rng is not None and form != "positions":
            sn = sn + nq * rng.standard_normal(n)
            c = c + nq * rng.standard_normal(n)
            if hit is not None and PO["tgt"] == "q" and i in PO["segs"]:
                sn = sn + hw["noise"] * hit * np.cos(1 + i)
                c = c + hw["noise"] * hit * np.sin(2 + i)
            sn, c = np.round(sn), np.round(c)
        s, P = E("u_quant")
        if P and form != "positions" and i in P["segs"]:
            q = s                        # a power of two
            sn, c = np.floor(sn / q) * q, np.floor(c / q) * q
        if rng is not None and form != "positions":
            out["over"] = out.get("over", 0) + int(np.sum(np.maximum(np.abs(sn), np.abs(c)) > 32767))
            sn, c = np.clip(sn, -32768, 32767), np.clip(c, -32768, 32767)
        sn, c = sn + 0., c + 0.              # no negative zero: the file cannot hold it
        fr = RHO / (2 * np.pi) * np.arctan2(sn, c)
        nt = np.round((own[i] - fr) / RHO)
        s, P = E("cycle_slip")
        if P and P["seg"] == i:
            k0 = int(per(60).uniform(.25, .75) * m.nfull)
            nt = nt + P["k"] * (m.idx >= k0)
        p = nt * RHO + fr
        if form == "positions":
            s, P = E("u_quant")
            if rng is not None:
                p = p + npos * rng.standard_normal(n)
                if hit is not None and PO["tgt"] == "q" and i in PO["segs"]:
                    p = p + hw["pos_noise"] * hit * (1 if i % 2 else -.8)
            if P and i in P["segs"]:
                p = np.floor(p / (s * 1e-8)) * s * 1e-8
        out["p"][i] = p
        out["q%d" % (i + 1)] = (sn, c, nt)
    if hw["diode"]:
        e = [np.where(m.see, a, 0.) for a in el]
        if rng is not None:
            for k in range(4):
                a = e[k] + npd * rng.standard_normal(n)
                if hit is not None and PO["tgt"] == "psd":
                    a = a + hw["pnoise"] * hit * (1 if k in (0, 3) else -.7)
                out["over"] = out.get("over", 0) + int(np.sum((a > 32767) & m.see))
                e[k] = np.where(m.see, np.clip(np.round(a), 1, 32767), 0.)
        out["el"] = e
        S1, S2 = np.where(m.see, e[0] + e[1], 1.), np.where(m.see, e[2] + e[3], 1.)
        out["tan"] = (hw["tfs"] * (e[0] - e[1]) / S1, hw["tfs"] * (e[2] - e[3]) / S2)
    if ref:
        out["ref"] = m.X[0] + (0 if rng is None else 5e-8 * rng.standard_normal(n))
    return out


# ---------------------------------------------------------------- the baseline's least squares
def gam(p):
    f = 2 * np.pi / RHO * p
    return np.stack([np.ones_like(f), np.sin(f), np.cos(f), np.sin(2 * f), np.cos(2 * f), np.sin(4 * f), np.cos(4 * f), np.sin(6 * f), np.cos(6 * f)], 1)


def baseline(hw, m, o, form, robust=False):
    """fit equations (3), (5), (11); returns {channel: residual}"""
    if form == "reference":
        G = gam(o["p"][0])
        e = o["p"][0] - o["ref"]
        k = np.linalg.lstsq(G, -(e - e.mean()), rcond=None)[0]
        return {"segment_1": e - e.mean() + G @ k}
    p = np.stack(o["p"], 1)
    ls = hw["ls"]
    G = [gam(p[:, i]) for i in range(4)]
    sgn = [1, -1, -1, 1]
    gp0 = p @ np.array([1., -1, -1, 1])
    med = np.median(gp0)
    ss = hw["pos_noise"] if form == "positions" else RHO / 2 / np.pi * hw["noise"] / hw["amp0"]
    J = np.concatenate([sgn[i] * G[i] for i in range(4)], 1)
    Jp = J / (2 * ss)
    see = m.see
    if not (hw["diode"] and see.any()):
        kk = np.linalg.lstsq(Jp * 1., -(gp0 - med) / (2 * ss), rcond=1e-9)[0]
        return {"g_p": gp0 - med + J @ kk}
    tx, ty = o["tan"][0][see], o["tan"][1][see]
    ps = p[see]
    pc = ps.mean(0)
    Gs = [g[see] for g in G]
    k = np.zeros(36)
    k[9 * 0] = -med / 4; k[9] = med / 4; k[18] = med / 4; k[27] = -med / 4
    h, lx, ly = hw["h0"], hw["l0"][0], hw["l0"][1]
    sc = hw["h0"] * hw["tfs"] * 1.41 * hw["pnoise"] / hw["psum"]
    sx = np.sqrt(ss ** 2 / 2 + (ly * ss / ls) ** 2 + sc ** 2)
    sy = np.sqrt(ss ** 2 / 2 + (lx * ss / ls) ** 2 + sc ** 2)
    # zero of theta: from the readings the angle is known but for a constant; start from the commanded mean
    th_raw = ((ps[:, 0] - ps[:, 2]) + (ps[:, 1] - ps[:, 3])) / (2 * ls)
    th0 = np.mean(th_raw - m.X[2][see])
    for i in range(4):
        k[9 * i] += -SG[i] * th0 * ls / 2
    ox = oy = None
    for it in range(4):
        ph = np.stack([ps[:, i] + Gs[i] @ k[9 * i:9 * i + 9] for i in range(4)], 1)
        th = ((ph[:, 0] - ph[:, 2]) + (ph[:, 1] - ph[:, 3])) / (2 * ls)
        px, py = (ph[:, 0] + ph[:, 2]) / 2, (ph[:, 1] + ph[:, 3]) / 2
        co, si = np.cos(th), np.sin(th)
        gx = -px + co * h * tx - si * h * ty - ly * si + lx * co
        gy = -py + si * h * tx + co * h * ty + ly * co + lx * si
        if ox is None:
            ox, oy = -np.mean(gx), -np.mean(gy)
        gx, gy = gx + ox, gy + oy
        gp = gp0 + J @ k
        if it == 3:
            break
        dxt = -si * h * tx - co * h * ty - ly * co - lx * si
        dyt = co * h * tx - si * h * ty - ly * si + lx * co
        Jx = np.concatenate([(-.5 if i % 2 == 0 else 0) * Gs[i] + (SG[i] / (2 * ls) * dxt)[:, None] * Gs[i] for i in range(4)]
                            + [np.stack([(co * tx - si * ty) * .05, co, -si, np.ones_like(si), 0 * si], 1)], 1)
        Jy = np.concatenate([(-.5 if i % 2 else 0) * Gs[i] + (SG[i] / (2 * ls) * dyt)[:, None] * Gs[i] for i in range(4)]
                            + [np.stack([(si * tx + co * ty) * .05, si, co, 0 * si, np.ones_like(si)], 1)], 1)
        JJ = np.concatenate([np.concatenate([Jp, np.zeros((len(gp), 5))], 1), Jx / sx, Jy / sy])
        rr = np.concatenate([gp / (2 * ss), gx / sx, gy / sy])
        if robust:
            wt = np.minimum(1, 4 * np.median(np.abs(rr)) / np.maximum(np.abs(rr), 1e-12))
            JJ, rr = JJ * wt[:, None], rr * wt
        cs = np.sqrt((JJ ** 2).sum(0))
        N = (JJ / cs).T @ (JJ / cs)
        ev, Q = np.linalg.eigh(N)
        b = Q.T @ ((JJ / cs).T @ -rr)
        keep = ev > 1e-11 * ev[-1]
        d = (Q[:, keep] @ (b[keep] / ev[keep])) / cs
        k += d[:36]
        h += d[36] * .05
        lx += d[37]; ly += d[38]; ox += d[39]; oy += d[40]
    return {"g_p": gp, "g_x": gx, "g_y": gy}


def size(hw, m, eff, form):
    res = baseline(hw, m, simulate(hw, m, eff, form), form)
    return {k: float(np.sqrt(np.mean((v - v.mean()) ** 2))) for k, v in res.items()}


def scale(r, name, hw, m, form, target):
    s = sub(m, max(1, m.n // 3000))
    for att in range(5):
        P = draw(r, name, hw, form)
        if name == "u_quant":
            best = None
            for q in ([2 ** b for b in range(6, 12)] if form != "positions" else [50, 100, 200, 400, 800, 1600]):
                z = max(size(hw, s, {name: (q, P)}, form).values())
                if best is None or abs(np.log(z / target)) < abs(np.log(best[1] / target)):
                    best = (q, z)
            return best[0], P, best[1]
        x = CAP[name] / 12
        ok = False
        for it in range(7):
            z = max(size(hw, s, {name: (x, P)}, form).values())
            if abs(z / target - 1) < .04:
                ok = True
                break
            x = min(x * np.clip((target / max(z, 1e-10)) ** (.7 if name == "adc_clipping" else 1.), .08, 8), CAP[name])
        if ok or (z > .75 * target and z < 1.4 * target):
            return x, P, z
    return x, P, z


# ---------------------------------------------------------------- writing
def write(d, hw, m, o, form, r, srcname):
    os.makedirs(d, exist_ok=True)
    T = ['schema = 1', 'device = "%s"' % srcname[0], 'source = "%s"' % srcname[1], '', '[geometry]', 'pitch_m = %.6g' % RHO,
         'span_m = %.6g' % hw["ls"], 'lateral_m = %.6g' % hw["lo"], '']
    if hw["diode"]:
        T += ['[coordination]', 'height_m = %.6g' % hw["h0"], 'lever_x_m = %.6g' % hw["l0"][0], 'lever_y_m = %.6g' % hw["l0"][1],
              'tan_full_scale = %.6g' % hw["tfs"], '']
    T += ['[electronics]']
    if form == "positions":
        T += ['position_noise_m = %.6g' % hw["pos_noise"]]
    else:
        T += ['adc_bits = 16', 'amplitude_counts = %.1f' % hw["amp0"], 'quadrature_noise_counts = %.6g' % hw["noise"]]
    if hw["diode"]:
        T += ['psd_sum_counts = %.1f' % hw["psum"], 'psd_noise_counts = %.6g' % hw["pnoise"]]
    open(d + "/recording.toml", "w").write("\n".join(T) + "\n")
    tick = 1e-6
    tt = np.round((m.T0 + m.t + r.uniform(-3e-6, 3e-6, m.n)) / tick) * tick
    assert np.all(np.diff(tt) > tick / 2)
    cols, fm = [tt, m.run], ["%.6f", "%s"]
    head = ["t_s", "run"]
    for i in range(4):
        if o["p"][i] is None:
            continue
        if form == "positions":
            head.append("p%d_m" % (i + 1)); cols.append(o["p"][i]); fm.append("%.9f")
        else:
            for a, v in zip(("q%ds", "q%dc", "n%d"), o["q%d" % (i + 1)]):
                head.append(a % (i + 1)); cols.append(v.astype(int)); fm.append("%d")
    if hw["diode"]:
        for a, v in zip(("psd_xp", "psd_xn", "psd_yp", "psd_yn"), o["el"]):
            head.append(a); cols.append(v.astype(int)); fm.append("%d")
    head.append("temp_c"); cols.append(m.temp_log); fm.append("%.2f")
    off = r.normal(0, 1, 3) * np.array([15e-6, 15e-6, 3e-4])
    st = m.pid < 0
    for a, nm in enumerate(("cmd_x_m", "cmd_y_m", "cmd_theta_rad")):
        sgm = [18e-6, 18e-6, 2.5e-4][a]
        e = np.where(st, r.normal(0, sgm, m.n), sgm * np.sin(2 * np.pi * m.X[0 if a == 0 else 1] / RHO + a) + sgm * m.V[a] / (.05 if a < 2 else .1))
        head.append(nm); cols.append(m.X[a] + off[a] + e); fm.append("%.7f")
    if form == "reference":
        head.append("ref_x_m"); cols.append(o["ref"]); fm.append("%.9f")
    f = ",".join(fm)
    rows = [f % x for x in zip(*[c.tolist() for c in cols])]
    open(d + "/samples.csv", "w").write(",".join(head) + "\n" + "\n".join(rows) + "\n")


# ---------------------------------------------------------------- the plan of the cases
def fits(names, form):
    if form == "beacon":
        return True
    if form == "nobeacon":
        return not any(a in NEED_DIODE for a in names)
    if form == "positions":
        return not any(a in NEED_COUNTS for a in names)
    return not any(a in NOT_REF for a in names)


def ufits(u, form):
    c = UNL[u][1]
    return {"beacon": "b" in c, "nobeacon": "n" in c, "positions": "p" in c or "P" in c, "reference": "r" in c}[form]


def plan(K):
    g = np.random.default_rng(90210)
    ones = NAMES * 3 + list(g.permutation(NAMES)[:6])
    # spread: each set gets every name once and two more
    ones_k = [list(NAMES) + ones[57 + 2 * i:59 + 2 * i] for i in range(3)]
    allp = [tuple(sorted(p)) for p in itertools.combinations(NAMES, 2)]
    g.shuffle(allp)
    allp = [tuple(p) for p in allp]
    cnt = {a: 0 for a in NAMES}
    pairs = []
    for _ in range(54):
        p = min((q for q in allp if q not in pairs), key=lambda q: max(cnt[q[0]], cnt[q[1]]) * 10 + cnt[q[0]] + cnt[q[1]])
        pairs.append(p)
        for a in p:
            cnt[a] += 1
    pairs = [pairs[i] for i in g.permutation(54)]
    ul = list(g.permutation(list(UNL))) + list(g.permutation(list(UNL))) + list(g.permutation(list(UNL)))
    ul = [str(a) for a in ul[:42]]
    k = K - 1
    r = np.random.default_rng([4411, K])
    C = [dict(kind="one", names=[str(a)]) for a in ones_k[k]] + [dict(kind="two", names=list(p)) for p in pairs[18 * k:18 * k + 18]]
    C += [dict(kind="none", names=[]) for _ in range(7)] + [dict(kind="unlisted", names=[u]) for u in ul[14 * k:14 * k + 14]]
    r.shuffle(C)
    for c in C:
        c["form"] = None
    for form, q in (("reference", 6), ("nobeacon", 9), ("positions", 9)):
        ok = [c for c in C if c["form"] is None and (ufits(c["names"][0], form) if c["kind"] == "unlisted" else fits(c["names"], form))]
        j = r.permutation(len(ok))[:q]
        for i in j:
            ok[i]["form"] = form
    for c in C:
        c["form"] = c["form"] or "beacon"
    r.shuffle(C)
    return C


DEV = ["courier %02d", "unit C%02d", "agent-%02d", "courier no. %d"]
SRC = ["bench log", "recorder", "field log", "logger 2", "night shift"]


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--set", type=int, required=True)
    ap.add_argument("--out", required=True)
    ap.add_argument("--only", type=int, default=None)
    a = ap.parse_args()
    truth = []
    for ci, c in enumerate(plan(a.set)):
        if a.only is not None and ci != a.only:
            continue
        r = np.random.default_rng([7177, a.set, ci])
        form, names = c["form"], c["names"]
        hw = make_hw(r, form, names)
        if form == "positions":
            nd = any(x in NEED_DIODE for x in names) or (c["kind"] == "unlisted" and "p" not in UNL[names[0]][1])
            hw["diode"] = bool(nd or r.random() < .5)
        else:
            hw["diode"] = form == "beacon"
        need = any(x in ("u_pitch", "u_flex", "u_jitter", "u_motor") for x in names)
        big = "thermal_drift" in names or r.random() < .25
        ms = []
        for k in range(2):
            for fsk in (1., .85, .7, .6):
                hw["fsk"] = fsk
                m = make_motion(r, hw, form, hw["diode"], need, int(r.integers(1 << 30)))
                if m.n <= 13900:
                    break
            temps(r, m, big)
            ms.append(m)
        eff, sizes = {}, {}
        for nm in names:
            if nm in NO_RMS:
                eff[nm] = (1., draw(r, nm, hw, form))
                sizes[nm] = None
            else:
                s, P, z = scale(r, nm, hw, ms[0], form, logu(r, .7, 4.) * UM)
                eff[nm] = (float(s), P)
                sizes[nm] = z
        # the second recording must show about the same: another motion and course until it does
        for tr in range(14):
            q = [max(size(hw, sub(ms[1], max(1, ms[1].n // 3000)), {nm: eff[nm]}, form).values()) / sizes[nm] for nm in names if sizes[nm]]
            if all(.62 < v < 1.6 for v in q):
                break
            m = make_motion(r, hw, form, hw["diode"], need, int(r.integers(1 << 30)))
            temps(r, m, big)
            if m.n <= 13900:
                ms[1] = m
        src = (str(r.choice(DEV)) % r.integers(1, 40), str(r.choice(SRC)))
        over = 0
        for k, m in enumerate(ms):
            o = simulate(hw, m, eff, form, np.random.default_rng([m.seed, 99]))
            over += o.get("over", 0)
            write("%s/c%03d/%s" % (a.out, ci, ("first", "second")[k]), hw, m, o, form, r, src)
        z2 = {nm: (max(size(hw, sub(ms[1], max(1, ms[1].n // 3000)), {nm: eff[nm]}, form).values()) if sizes[nm] else None) for nm in names}
        clean = lambda v: v.tolist() if isinstance(v, (np.ndarray, np.generic)) else v
        par = {nm: dict(strength=eff[nm][0], rms_first=sizes[nm], rms_second=z2[nm],
                        **{k: clean(v) for k, v in eff[nm][1].items() if isinstance(k, str) and k != "F"}) for nm in names}
        zz = [z for z in sizes.values() if z]
        un = c["kind"] == "unlisted"
        truth.append(dict(case="c%03d" % ci, kind=c["kind"], form=form, effects=[] if un else names, unlisted=UNL[names[0]][0] if un else None,
                          places=UNL[names[0]][2] if un else [], params=par, rms_m=max(zz) if zz else None))
        print(ci, c["kind"], form, "diode" if hw["diode"] else "", [m.n for m in ms],
              {nm: (sizes[nm] and round(sizes[nm] * 1e6, 2), z2[nm] and round(z2[nm] * 1e6, 2), "s=%.3g" % eff[nm][0]) for nm in names}, "over %d" % over if over else "", flush=True)
    os.makedirs(a.out, exist_ok=True)
    if a.only is None:
        json.dump(truth, open(a.out + "/truth.json", "w"), indent=1, default=lambda v: v.tolist() if hasattr(v, "tolist") else str(v))


if __name__ == "__main__":
    main()
