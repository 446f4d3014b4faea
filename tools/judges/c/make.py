#!/usr/bin/env python3
"""Independent simulator of a courier's sensors with one hidden physical effect or more. numpy only.
True pose(t) -> geometry at each segment -> flux/coil voltages -> counts; beacon image -> electrode currents -> counts."""
import os
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import argparse, json, zlib
import numpy as np

RHO = 1.016e-3
F = 2 * np.pi / RHO
# ------------------------------------------------------------------------------------------------ motion

class Run:
    """arrays over samples: t, pose (3,N), vel, acc, log mask, psd seen."""
    def __init__(s, name, t, q, v, a, log, beacon):
        s.name, s.t, s.q, s.v, s.a, s.log, s.beacon = name, t, q, v, a, log, beacon

def servo_kernel(rng, dt):
    w = 2 * np.pi * rng.uniform(14, 38); z = rng.uniform(0.45, 0.85)
    t = np.arange(0, 0.25, dt); wd = w * np.sqrt(1 - z * z)
    k = np.exp(-z * w * t) * np.sin(wd * t); return k / k.sum()

def scurve(rng, D, V, fs, kern, dt=2.5e-4):
    """jerk limited profile of distance D at speed V through the servo's second-order response"""
    Ta, Tj = rng.uniform(0.05, 0.12), rng.uniform(0.015, 0.04)
    n = lambda T: max(2, int(round(T / dt)))
    v = np.ones(n(abs(D) / V))
    for T in (Ta, Tj):
        v = np.convolve(v, np.ones(n(T)) / n(T))
    v = np.convolve(np.concatenate([np.zeros(n(0.03)), v, np.zeros(n(0.12))]), kern)[:len(v) + n(0.15)]
    v *= D / (v.sum() * dt)
    return np.arange(len(v)) * dt, np.cumsum(v) * dt, np.abs(v) / V

def wander(rng, t, amp, n=3, fmax=7.0):
    o = np.zeros_like(t)
    for _ in range(n):
        f = np.exp(rng.uniform(np.log(0.15), np.log(fmax)))
        o += amp / np.sqrt(n) * rng.uniform(.4, 1.3) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28)) / (1 + f / 3)
    return o

def rot(th, ax, ay):
    return np.cos(th) * ax - np.sin(th) * ay, np.sin(th) * ax + np.cos(th) * ay

def to_pose(hw, cx, cy, th):
    X, Y = rot(th, cx + hw["lx"], cy + hw["ly"])
    return X + hw["ox"], Y + hw["oy"]

def dense_run(rng, name, hw, fs, axis, start, D, V, beacon, frame):
    dt = 2.5e-4
    t, s, env = scurve(rng, D, V, fs, servo_kernel(rng, dt))
    q = [np.full_like(t, start[j]) for j in range(3)]
    q[axis] = q[axis] + s
    if axis < 2:
        q[axis] = q[axis] + np.clip(env, 0, 1) * rng.uniform(1e-6, 6e-6) * np.sin(F * q[axis] + rng.uniform(0, 6.28))
    for j in range(3):
        q[j] = q[j] + wander(rng, t, rng.uniform(1, 5) * 1e-6 if j < 2 else rng.uniform(1, 8) * 1e-5)
    if frame == "c":
        q[0], q[1] = to_pose(hw, q[0], q[1], q[2])
    q = np.array(q)
    v = np.gradient(q, dt, axis=1); a = np.gradient(v, dt, axis=1)
    tl = np.arange(0, t[-1], 1 / fs)
    ip = lambda A: np.array([np.interp(tl, t, r) for r in A])
    return Run(name, tl, ip(q), ip(v), ip(a), np.ones(len(tl), bool), beacon)

def still_run(rng, name, poses, fs, burst, beacon, q0):
    """poses (3,M): arrive by a monotone move with a small overshoot (an unlogged waypoint), settle, log a burst"""
    T, Q, V, A, L = [], [], [], [], []
    t = 0.0; prev = np.array(q0, float)
    w = 2 * np.pi * rng.uniform(14, 35); z = rng.uniform(0.25, 0.6)
    wait = rng.uniform(0.07, 0.16); over = rng.uniform(0.3e-6, 2e-6)
    for p in poses.T:
        d = p - prev
        t += 0.12 + np.sqrt(np.abs(d[:2]).max() / 1.2) + abs(d[2]) * 3 + rng.exponential(0.06)
        u = np.sign(d) * np.array([over, over, over * 40]) * rng.uniform(.3, 1.2, 3)
        T.append([t]); Q.append((p + u)[:, None]); V.append(np.zeros((3, 1))); A.append(np.zeros((3, 1))); L.append([False])
        tb = wait * rng.uniform(.9, 1.3) + np.arange(burst) / fs
        wd = w * np.sqrt(1 - z * z); s = -z * w + 1j * wd
        e = np.exp(s * tb)
        slow = rng.normal(0, 3e-7, 3) * np.array([1, 1, 30])
        ph = 2 * np.pi * rng.uniform(1, 4) * tb + rng.uniform(0, 6)
        Q.append(p[:, None] + u[:, None] * e.real + slow[:, None] * np.sin(ph))
        V.append(u[:, None] * (s * e).real); A.append(u[:, None] * (s * s * e).real)
        T.append(t + tb); L.append([True] * burst)
        t += tb[-1] + 0.02; prev = p
    return Run(name, np.concatenate(T), np.hstack(Q), np.hstack(V), np.hstack(A), np.concatenate(L).astype(bool), beacon)

def motion(rng, hw, form, rec):
    fs = float(rng.choice([250, 320, 400, 500])); runs = []
    if hw["fs"]: fs = hw["fs"]
    b = hw["diode"]
    if form == "reference":
        x0, Lg = hw["fx"] + rng.uniform(-.4e-3, .4e-3), rng.uniform(40e-3, 55e-3)
        y0, th0 = hw["fy"], hw["fth"]
        M = int(rng.integers(150, 320)); P = np.vstack([rng.uniform(x0, x0 + Lg, M), np.full(M, y0), np.full(M, th0)])
        runs.append(still_run(rng, "scatter", P, fs, int(rng.integers(5, 11)), False, [x0, y0, th0]))
        for V, nm in ((hw["vf"], ""), (hw["vs"], "_slow"), (hw["vm"], "_mid")):
            runs.append(dense_run(rng, "flyby_x" + nm, hw, fs, 0, [x0, y0, th0], Lg, V, False, "p"))
            runs.append(dense_run(rng, "flyby_x%s_back" % nm, hw, fs, 0, [x0 + Lg, y0, th0], -Lg, V, False, "p"))
        runs.append(still_run(rng, "still", np.array([[x0 + Lg / 2], [y0], [th0]]), fs, int(fs), False, [x0, y0, th0]))
        return runs, fs
    M = int(rng.integers(330, 600)); bu = int(rng.integers(2, 5))
    P = np.vstack([rng.uniform(0, 10 * RHO, M), rng.uniform(0, 10 * RHO, M), rng.uniform(-.5, .5, M) * np.pi / 180])
    runs.append(still_run(rng, "scatter", P, fs, bu, False, [5e-3, 5e-3, 0]))
    late = []
    jx, jy = rng.uniform(-.6e-3, .6e-3, 2)
    for ax, nm in ((0, "flyby_x"), (1, "flyby_y")):
        st = [hw["fx"], hw["fy"] + jy, hw["fth"]] if ax == 0 else [hw["gx"] + jx, hw["gy"], hw["fth"]]
        for V, sfx in ((hw["vf"], ""), (hw["vs"], "_slow")):
            if sfx and ax == 0 and (not hw["slowx"] or fs > 450): continue
            e = list(st); e[ax] += 40e-3
            late.append(dense_run(rng, nm + sfx, hw, fs, ax, st, 40e-3, V, False, "p"))
            late.append(dense_run(rng, nm + sfx + "_back", hw, fs, ax, e, -40e-3, V, False, "p"))
    d2r = np.pi / 180
    late.append(dense_run(rng, "spin", hw, fs, 2, [0, 0, -1.2 * d2r], 2.4 * d2r, rng.uniform(1, 2.5) * d2r, b, "c"))
    if b:
        M = int(rng.integers(330, 620))
        c = rng.uniform(-RHO, RHO, (2, M)); th = rng.uniform(-1.5, 1.5, M) * d2r
        X, Y = to_pose(hw, c[0], c[1], th)
        runs.insert(int(rng.integers(0, 2)), still_run(rng, "beacon", np.vstack([X, Y, th]), fs, bu, True, [X[0] - 1e-3, Y[0] + 1e-3, 0]))
        for ax, nm in ((0, "beacon_x"), (1, "beacon_y")):
            off = rng.uniform(-.3e-3, .3e-3); V = hw["vb"]
            st = [off, off, hw["fth"] * .5]; st[ax] = -4e-3; e = list(st); e[ax] = 4e-3
            late.append(dense_run(rng, nm, hw, fs, ax, st, 8e-3, V, True, "c"))
            late.append(dense_run(rng, nm + "_back", hw, fs, ax, e, -8e-3, V, True, "c"))
    if rng.random() < .4: late = late[::-1] if rng.random() < .5 else late[2:] + late[:2]
    runs += late
    X, Y = to_pose(hw, 0.2e-3, -.1e-3, 0.0)
    runs.append(still_run(rng, "still", np.array([[X], [Y], [0.002]]), fs, int(fs * rng.uniform(.8, 1.6)), b, [X + 1e-3, Y, 0]))
    return runs, fs

class Traj: pass

def trajectory(seed, hw, form, rec):
    rng = np.random.default_rng([seed, 77, rec])
    runs, fs = motion(rng, hw, form, rec)
    T = Traj(); t0 = rng.uniform(0.5, 30.0); ts, nm, sb = [], [], []
    for r in runs:
        ts.append(r.t + t0); t0 = ts[-1][-1] + rng.uniform(0.4, 5.0)
        nm += [r.name] * len(r.t); sb.append(np.full(len(r.t), r.beacon))
    T.t = np.concatenate(ts); T.name = np.array(nm); T.psd = np.concatenate(sb)
    T.q = np.hstack([r.q for r in runs]); T.v = np.hstack([r.v for r in runs]); T.a = np.hstack([r.a for r in runs])
    T.log = np.concatenate([r.log for r in runs]); T.rec = rec; T.fs = fs
    drop = rng.random(len(T.t)) < rng.choice([0, 2e-4, 1e-3]); T.log &= ~drop      # logger loses a frame now and then
    # temperature: warm-up plus room and load cycles
    d = T.t[-1]; dT = hw["dT"]
    tau = d * rng.uniform(.12, .5)
    T.T = rng.uniform(20, 27) + dT * (1 - np.exp(-T.t / tau)) * rng.choice([-1, 1], p=[.2, .8]) \
        + .35 * dT * np.sin(2 * np.pi * T.t / (d * rng.uniform(.35, .8)) + rng.uniform(0, 6.28)) + wander(rng, T.t / 40, .1)
    if hw["thermal"] :
        pp = np.ptp(T.T); T.T = T.T.mean() + (T.T - T.T.mean()) * max(1, rng.uniform(9, 14) / pp)
    return T

# ------------------------------------------------------------------------------------------------ hardware

def hardware(rng, form, names, diode):
    U = rng.uniform; h = {}
    h["ls"], h["lo"] = 9.7e-3, U(3.5e-3, 6.5e-3)
    h["esp"] = U(-.7e-6, .7e-6, 4); h["elo"] = U(-4e-6, 4e-6, 4)
    h["diode"] = diode
    h["h"] = U(40e-3, 85e-3); h["tfs"] = U(5.4e-3, 7.5e-3) / h["h"]; h["lx"] = U(70e-3, 100e-3) * rng.choice([1, 1, -1]); h["ly"] = U(-12e-3, 12e-3)
    h["hn"] = h["h"] * (1 + U(-.04, .04)); h["lxn"] = h["lx"] + U(-1.5e-3, 1.5e-3); h["lyn"] = h["ly"] + U(-1.5e-3, 1.5e-3)
    h["ox"] = U(2e-3, 9e-3) - h["lx"]; h["oy"] = U(2e-3, 9e-3) - h["ly"]
    h["A0"] = float(round(U(20000, 26500), -2)); h["A"] = h["A0"] * U(.93, 1.07, 4)
    if "gap_variation" in names: h["A0"] = float(round(U(20000, 21500), -2)); h["A"] = h["A0"] * U(.96, 1.04, 4)
    h["g"] = U(-.03, .03, 4); h["ps"] = U(-1.6, 1.6, 4) * np.pi / 180
    h["os"] = U(-.006, .006, 4); h["oc"] = U(-.006, .006, 4)
    h["h3s"], h["h3c"] = U(-.006, .006, 4), U(-.006, .006, 4); h["h2"] = U(-.002, .002, 4); h["h5"] = U(-.0006, .0006, 4)
    h["z"] = U(-30e-6, 30e-6, 4)
    h["qn"] = float(round(U(10, 25), 1)); h["S"] = float(round(U(26000, 36000), -2)); h["pn"] = float(round(U(1.0, 3.2), 1))
    h["posn"] = float("%.2g" % U(.06e-6, .25e-6))
    h["fx"], h["fy"], h["fth"] = U(-12e-3, -4e-3), U(2e-3, 8e-3), U(-2e-3, 2e-3)
    h["gx"], h["gy"] = U(2e-3, 8e-3), U(-12e-3, -4e-3)
    h["vf"], h["vs"], h["vm"], h["vb"] = U(45e-3, 60e-3), U(14e-3, 22e-3), U(28e-3, 36e-3), U(17e-3, 24e-3)
    h["slowx"] = rng.random() < .5; h["fs"] = None
    h["thermal"] = "thermal_drift" in names
    h["dT"] = U(9, 13) if h["thermal"] or rng.random() < .3 else U(.8, 4.5)
    # baseline imperfections of the diode that h, l and o take up
    return h

def seg_uv(hw, q, esp):
    """own and lateral positions of the four segments over the platen, as the documents' small-angle geometry has it"""
    x, y, th = q; a = hw["ls"] / 2; lo = hw["lo"] + hw["elo"]
    u = np.array([x + (a + esp[0]) * th, y + (a + esp[1]) * th, x - (a + esp[2]) * th, y - (a + esp[3]) * th])
    w = np.array([y - lo[0] * th, x + lo[1] * th, y + lo[2] * th, x - lo[3] * th])
    return u, w

# where on the platen a segment lies: constant offsets on the body (pinwheel), which phases and offsets take up elsewhere
OWN, LAT = (-1, -1, 1, 1), (-1, 1, 1, -1)

class St: pass

def simulate(hw, T, effs, nrng=None, form="beacon"):
    """effs: list of (hooks, strength). Returns state with noise-free outputs; with nrng the counts too."""
    S = St(); S.T = T; S.hw = hw; N = len(T.t); S.N = N; S.esp = hw["esp"].copy(); S.form = form
    def call(stage):
        for hk, k in effs:
            if stage in hk: hk[stage](S, k)
    call("build")
    S.u, S.w = seg_uv(hw, T.q, S.esp); S.vu, _ = seg_uv({**hw}, T.v, S.esp); S.au, _ = seg_uv(hw, T.a, S.esp)
    S.u_true = S.u.copy(); S.th = T.q[2]
    z = lambda v=0.: np.full((4, N), v)
    S.amp, S.dos, S.doc, S.dg, S.dps, S.h3 = z(1.), z(), z(), z(), z(), z(1.)
    call("geom")
    call("elec")
    S.phi = F * (S.u + hw["z"][:, None]); p = S.phi
    g = hw["g"][:, None] + S.dg; ps = hw["ps"][:, None] + S.dps
    h5 = hw["h5"][:, None]; h2 = hw["h2"][:, None]
    S.s = S.amp * ((1 + g / 2) * np.sin(p + ps / 2) + S.h3 * hw["h3s"][:, None] * np.sin(3 * p) + h2 * np.sin(2 * p) + h5 * np.sin(5 * p)) + hw["os"][:, None] + S.dos
    S.c = S.amp * ((1 - g / 2) * np.cos(p - ps / 2) + S.h3 * hw["h3c"][:, None] * np.cos(3 * p) + h2 * np.cos(2 * p) + h5 * np.cos(5 * p)) + hw["oc"][:, None] + S.doc
    call("sig")
    # coordination sensor
    S.qc = T.q; S.bx = np.zeros(N); S.by = np.zeros(N)
    call("when")
    dx, dy = S.qc[0] - hw["ox"] - S.bx, S.qc[1] - hw["oy"] - S.by; th = S.qc[2]
    S.cx = np.cos(th) * dx + np.sin(th) * dy - hw["lx"]; S.cy = -np.sin(th) * dx + np.cos(th) * dy - hw["ly"]
    call("c")
    S.ux, S.uy = S.cx / hw["h"] / hw["tfs"], S.cy / hw["h"] / hw["tfs"]; S.S = np.full(N, hw["S"]) * (1 - .04 * (S.ux ** 2 + S.uy ** 2))
    call("psd")
    S.el = np.array([S.S / 2 * (1 + S.ux), S.S / 2 * (1 - S.ux), S.S / 2 * (1 + S.uy), S.S / 2 * (1 - S.uy)]); 
    call("elec_psd")
    A = hw["A"][:, None]
    S.qs, S.qcn = A * S.s, A * S.c
    S.n0 = None
    fr = lambda a, b: RHO / 2 / np.pi * np.arctan2(a, b)
    def unwrap(a, b):
        f = fr(a, b); n = np.round((S.u + hw["z"][:, None] - f) / RHO); return n, n * RHO + f
    S.slip = np.zeros((4, N)); call("slip")
    S.pos_add = np.zeros((4, N)); S.nf = 1.0; S.nfp = 1.0
    call("noise")
    _, S.p = unwrap(S.qs, S.qcn)
    call("interp")
    S.pm = S.p + S.slip * RHO
    if nrng is not None:
        r = nrng
        ns = r.normal(0, 1, (2, 4, N)) * hw["qn"] * S.nf
        burst = np.zeros((2, 4, N)); S.pb = np.zeros((4, N)); S.eb = np.zeros((4, N)); S.burst = burst
        call("burst")
        S.Qs = np.clip(np.round(S.qs + ns[0] + burst[0]), -32768, 32767).astype(int)
        S.Qc = np.clip(np.round(S.qcn + ns[1] + burst[1]), -32768, 32767).astype(int)
        n, _ = unwrap(S.Qs, S.Qc); S.n = (n + S.slip).astype(int)
        S.P = S.p + S.slip * RHO + r.normal(0, 1, (4, N)) * hw["posn"] * S.nf + S.pb
        S.E = np.clip(np.round(S.el + r.normal(0, 1, (4, N)) * hw["pn"] * S.nfp + S.eb), 0, 32767).astype(int)
    return S

# ------------------------------------------------------------------------------------------------ baseline fit

def gam(p, drop0=False):
    f = F * p; one = np.ones_like(p)
    return np.array([one] + [fn(m * f) for m in (1, 2, 4, 6) for fn in (np.sin, np.cos)]).T

def fit_residual(hw, form, p, el, psd, ref, step=1, sig=None):
    """p (4,N) raw outputs (m); el electrodes (4,N); returns dict of residual arrays"""
    if form == "reference":
        e = p[0] - ref; G = gam(p[0]); k = np.linalg.lstsq(G, e, rcond=1e-10)[0]; return {"segment_1": e - G @ k}
    p = p[:, ::step]; psd = psd[::step]; el = el[:, ::step]
    N = p.shape[1]; ls = 9.7e-3
    G = [gam(p[i]) for i in range(4)]; sg = [1, -1, -1, 1]
    Ap = np.hstack([sg[i] * G[i] for i in range(4)]); gp = (p[0] - p[2]) - (p[1] - p[3])
    if not psd.any():
        k = np.linalg.lstsq(Ap, -gp, rcond=1e-9)[0]; return {"g_p": gp + Ap @ k}
    sq = RHO / 2 / np.pi * hw["qn"] / hw["A0"] if form == "beacon" else hw["posn"]
    sc = hw["h"] * hw["tfs"] * hw["pn"] * 1.42 / hw["S"]; sth = sq / ls
    wp, wx, wy = 1 / (2 * sq), 1 / np.hypot(sc, np.hypot(sq * .7, sth * hw["ly"])), 1 / np.hypot(sc, np.hypot(sq * .7, sth * hw["lx"]))
    b = np.flatnonzero(psd); k = np.zeros(36); h, lx, ly, ox, oy = hw["h"], hw["lx"], hw["ly"], hw["ox"], hw["oy"]
    tx = hw["tfs"] * (el[0, b] - el[1, b]) / (el[0, b] + el[1, b]); ty = hw["tfs"] * (el[2, b] - el[3, b]) / (el[2, b] + el[3, b])
    Gb = [g[b] for g in G]
    for it in range(3):
        ph = np.array([p[i] + G[i] @ k[9 * i:9 * i + 9] for i in range(4)])
        r_p = (ph[0] - ph[2]) - (ph[1] - ph[3]); pb = ph[:, b]
        th = ((pb[0] - pb[2]) + (pb[1] - pb[3])) / 2 / ls; c, s = np.cos(th), np.sin(th); cx, cy = h * tx, h * ty
        rx = -(pb[0] + pb[2]) / 2 + c * cx - s * cy - ly * s + lx * c + ox
        ry = -(pb[1] + pb[3]) / 2 + s * cx + c * cy + ly * c + lx * s + oy
        if it == 2: break
        dxt = -s * cx - c * cy - ly * c - lx * s; dyt = c * cx - s * cy - ly * s + lx * c
        st = [.5 / ls, .5 / ls, -.5 / ls, -.5 / ls]
        Jx = np.hstack([(dxt * st[i] - (.5 if i in (0, 2) else 0))[:, None] * Gb[i] for i in range(4)] + [np.array([c * tx - s * ty, c, -s, np.ones_like(c), 0 * c]).T])
        Jy = np.hstack([(dyt * st[i] - (.5 if i in (1, 3) else 0))[:, None] * Gb[i] for i in range(4)] + [np.array([s * tx + c * ty, s, c, 0 * c, np.ones_like(c)]).T])
        J = np.vstack([np.hstack([Ap, np.zeros((N, 5))]) * wp, Jx * wx, Jy * wy]); r = np.concatenate([r_p * wp, rx * wx, ry * wy])
        cs = np.sqrt((J ** 2).sum(0)) + 1e-30
        H = (J / cs).T @ (J / cs); ev, Vv = np.linalg.eigh(H); keep = ev > 1e-11 * ev[-1]
        d = -(Vv[:, keep] @ ((Vv[:, keep].T @ ((J / cs).T @ r)) / ev[keep])) / cs
        k = k + d[:36]; h += d[36]; lx += d[37]; ly += d[38]; ox += d[39]; oy += d[40]
    return {"g_p": r_p, "g_x": rx, "g_y": ry}

def rms(a): return float(np.sqrt(np.mean(np.square(a))))

def size(hw, form, T, effs, step=2):
    S = simulate(hw, T, effs, None, form); L = T.log
    r = fit_residual(hw, form, S.pm[:, L], S.el[:, L], T.psd[L], S.u_true[0][L], step)
    return {k: rms(v) for k, v in r.items()}

# ------------------------------------------------------------------------------------------------ effects of the catalogue
# each builder(rng, hw, form, ns) -> (hooks, params). Hooks get the state and the strength k (about one).

def some(rng, lo=1, hi=4):
    m = np.zeros(4); m[rng.choice(4, int(rng.integers(lo, hi + 1)), replace=False)] = 1
    return m

def timerng(ns, S): return np.random.default_rng([ns, S.T.rec, 5])

def e_lateral(rng, hw, form, ns):
    a = rng.normal(0, 1, 4) * some(rng, 1, 4); b = rng.uniform(0, .6) * rng.normal(0, 1, 4) * (a != 0); kk = rng.uniform(.2, 1.3)
    f1, f2 = rng.uniform(0, 6.28, (2, 4)); am = rng.uniform(0, .03, 4)
    def elec(S, k):   # edge teeth of the coil cores enter and leave the lateral slots: flux skews and its size breathes
        for i in range(4):
            t = F * S.w[i]
            S.u[i] += 1e-6 * k * (a[i] * np.tanh(kk * np.sin(t + f1[i])) / np.tanh(kk) + b[i] * np.sin(2 * t + f2[i]))
            S.amp[i] *= 1 + am[i] * np.cos(t + f1[i])
    return {"elec": elec}, {"a": a.tolist(), "b": b.tolist()}

def e_harm(rng, hw, form, ns):
    m = some(rng, 1, 4); tab = []
    for o in rng.choice([2, 4, 6, 8, 9, 11], int(rng.integers(1, 4)), replace=False):
        tab.append((int(o), rng.normal(0, .007, 4) * m, rng.normal(0, .007, 4) * m, rng.uniform(0, 6.28, 4), -1 if o in (2, 4) else 1))
    if form == "reference": tab = [(o, np.where(np.arange(4) == 0, a + .005, a), b, f, s) for o, a, b, f, s in tab]
    def sig(S, k):    # flux harmonics of the tooth and coil shape that eq. (3) does not foresee
        for o, a, b, f, sgn in tab:
            S.s += k * a[:, None] * np.sin(o * S.phi + f[:, None]); S.c += k * sgn * b[:, None] * np.cos(o * S.phi + f[:, None])
    return {"sig": sig}, {"signal_orders": [t[0] for t in tab]}

def e_tooth(rng, hw, form, ns):
    n = 150; o = 60
    d = rng.normal(0, 1, (2, n, n)); d += (rng.random((2, n, n)) < rng.uniform(0, .05)) * rng.normal(0, 5, (2, n, n))
    cor = rng.uniform(0, .35); d = d + cor * (np.roll(d, 1, 1) + np.roll(d, 1, 2))
    nu, nw = rng.uniform(2.5, 5.5), rng.uniform(2, 5)       # half-lengths of a segment's footprint, teeth
    def geom(S, k):
        R = lambda m: int(np.ceil(m)) + 1
        for i in range(4):
            U, W = (S.u[i] + OWN[i] * hw["lo"]) / RHO, (S.w[i] + LAT[i] * hw["ls"] / 2) / RHO; iu, iw = np.floor(U).astype(int), np.floor(W).astype(int)
            num = np.zeros(S.N); 
            win = lambda x, m: np.clip((m + .5 - np.abs(x)), 0, 1) * (1 - .25 * np.minimum(np.abs(x) / m, 1) ** 2)
            ju = np.arange(-R(nu), R(nu) + 2); jw = np.arange(-R(nw), R(nw) + 2)
            wu = np.array([win(iu + j - U, nu) for j in ju]); ww = np.array([win(iw + j - W, nw) for j in jw]); wu /= wu.sum(0); ww /= ww.sum(0)
            D = d[i % 2]
            for a_, j in enumerate(ju):
                for b_, l in enumerate(jw):
                    X, Y = np.clip(iu + j + o, 0, n - 1), np.clip(iw + l + o, 0, n - 1)
                    num += wu[a_] * ww[b_] * (D[X, Y])
            S.u[i] = S.u[i] - 2e-6 * k * num
    return {"geom": geom}, {"half_teeth": [nu, nw]}

def e_angle(rng, hw, form, ns):
    d = rng.normal(0, .1e-3, 4) * some(rng, 2, 4); W = rng.uniform(1e-3, 6e-3); ofs = rng.normal(0, .6, (2, 4)); q = rng.uniform(-1, 1, 4); h3k = rng.normal(0, .8, (2, 4))
    def elec(S, k):   # sine and cosine coil rows lie apart across the segment: turning shifts them against each other
        th = S.th[None]
        S.dps += k * F * d[:, None] * th * (1 + 12 * q[:, None] * th)
        S.dos += k * ofs[0][:, None] * th; S.doc += k * ofs[1][:, None] * th
        S._ah = k * h3k[:, :, None] * th * (np.sinc(3 * W * th / RHO))
    def sig(S, k):
        S.s += S._ah[0] * np.sin(3 * S.phi); S.c += S._ah[1] * np.cos(3 * S.phi)
    return {"elec": elec, "sig": sig}, {"row_distance_m": d.tolist()}

def e_psdnl(rng, hw, form, ns):
    k3, dcx, dcy, q, pin = rng.normal(0, .01), *rng.uniform(-.25, .25, 2), rng.normal(0, .004, 2), rng.normal(0, .012)
    k3 += .006 * np.sign(k3)
    def psd(S, k):    # lens distortion about a decentred axis, and the tetralateral diode's pin-cushion; sheet resistance gradient
        x, y = S.ux - dcx, S.uy - dcy; r2 = x * x + y * y
        nx = S.ux + k * (k3 * x * r2 * (1 - .15 * r2) + pin * x * y * y + q[0] * x * x); ny = S.uy + k * (k3 * y * r2 * (1 - .15 * r2) + pin * y * x * x + q[1] * y * y)
        S.ux, S.uy = nx, ny
    return {"psd": psd}, {"k3": k3}

def e_psdmis(rng, hw, form, ns):
    g = rng.choice([-1, 1]) * 2e-3; al = rng.normal(0, 2e-3)
    def psd(S, k):
        c, s = np.cos(al * k), np.sin(al * k); x = c * S.ux + s * S.uy; y = -s * S.ux + c * S.uy
        S.ux, S.uy = x * (1 + k * g / 2), y * (1 - k * g / 2)
    return {"psd": psd}, {"gain_difference": g, "turn_rad": al}

def e_thermal(rng, hw, form, ns):
    c = rng.normal(0, .3e-6, 4); sc = rng.uniform(6e-6, 20e-6); lag = rng.choice([0, 0, rng.uniform(4, 12)]); cb = rng.normal(0, .3e-6, 2)
    if form == "reference": c[0] = rng.choice([-1, 1]) * rng.uniform(.05e-6, .3e-6)
    def geom(S, k):
        t, Tm = S.T.t, S.T.T; Tl = Tm - lag * np.gradient(Tm, t + np.arange(len(t)) * 1e-12) if lag else Tm
        D = Tl - 23
        for i in range(4): S.u[i] = S.u[i] + k * (c[i] * D * (1 + .01 * D) - sc * D * (S.u[i] - 5e-3))
    return {"geom": geom}, {"um_per_K": (c * 1e6).tolist(), "per_K": sc}

def e_lag(rng, hw, form, ns):
    kind = rng.choice(["common", "each", "one"]); tau = {"common": np.full(4, 60e-6) * rng.uniform(.5, 1.5, 4), "each": rng.uniform(0, 120e-6, 4), "one": 100e-6 * some(rng, 1, 1)}[str(kind)]
    if form == "reference": tau[0] = 60e-6
    if not hw["diode"] and kind == "common": tau *= rng.uniform(.2, 1.8, 4)
    eddy = rng.uniform(.5, 6)
    def elec(S, k):   # R-C and eddy-current shielding act on the phasor: phase falls back, amplitude drops a little
        om = F * S.vu
        x = om * (k * tau)[:, None]; sh = 1 / (1 + (eddy * S.vu) ** 2)
        S.u = S.u - np.arctan(x * sh) / F + .5 * S.au * (k * tau)[:, None] ** 2; S.amp = S.amp / np.sqrt(1 + x * x)
    return {"elec": elec}, {"tau_s": tau.tolist()}

def e_psdlat(rng, hw, form, ns):
    tau = rng.choice([-1, 1, 1]) * 1e-4; filt = rng.uniform(0, .5)
    def when(S, k):
        q = S.T; d = tau * k; S.qc = q.q - d * q.v + (.5 + filt * .5) * d * d * q.a
    return {"when": when}, {"tau_s": tau}

def e_hyst(rng, hw, form, ns):
    r = np.array([3e-6, 8e-6, 20e-6]) * rng.uniform(.8, 1.6); wt = rng.dirichlet([1.5, 2, 1]); b = rng.uniform(.3, 1.2, 4) * (1 if rng.random() < .5 else rng.choice([-1, 1], 4)) * some(rng, 2, 4)
    if form == "reference": b[0] = 1
    if not hw["diode"] and form != "reference": b = rng.normal(0, 1, 4)
    def geom(S, k):   # Prandtl-Ishlinskii: plays of several widths, fed with the path including overshoots between samples
        u = S.u_true; key = id(S.T)
        if cache.get("k") != key:
            out = np.zeros_like(u)
            st = [u[:, 0].copy() for _ in r]
            z = np.zeros((3, 4, S.N)); ut = np.ascontiguousarray(u.T); cur = np.array([ut[0]] * 3); R = r[:, None]
            for n in range(S.N):
                x = ut[n]; cur = np.minimum(np.maximum(cur, x - R), x + R); z[:, :, n] = (cur - x) / R
            cache["k"] = key; cache["T"] = S.T; cache["z"] = z
        S.u = S.u + 1e-6 * k * b[:, None] * np.einsum("j,jin->in", wt, cache["z"])
    cache = {}
    return {"geom": geom}, {"b": b.tolist(), "plays_m": r.tolist()}

def e_gap(rng, hw, form, ns):
    K = []
    for _ in range(5):
        lam = np.exp(rng.uniform(np.log(9e-3), np.log(70e-3))); an = rng.uniform(0, 6.28); K.append((2 * np.pi / lam * np.cos(an), 2 * np.pi / lam * np.sin(an), rng.uniform(0, 6.28), rng.uniform(.5, 1) * (lam / 30e-3) ** .3))
    nrm = np.sqrt(sum(a[3] ** 2 for a in K) / 2); z0 = rng.uniform(10e-6, 19e-6); tilt = rng.uniform(-.5, .5, 4) * 1e-3
    of = rng.normal(0, .02, (2, 4)); sk = rng.normal(0, .01, 4)
    of += .012 * np.sign(of)
    def elec(S, k):   # platen out of flat: gap field; feed-through stays while the signal goes as exp(-2 pi z / rho); h3 falls thrice as fast
        for i in range(4):
            U, W = S.u[i] + OWN[i] * hw["lo"], S.w[i] + LAT[i] * hw["ls"] / 2; X, Y = (U, W) if i % 2 == 0 else (W, U)
            z = z0 / nrm * sum(a * np.cos(kx * X + ky * Y + f) for kx, ky, f, a in K) + tilt[i] * (X - 5e-3) + 0 * Y
            z = 38e-6 * np.tanh(z / 38e-6)
            S.amp[i] *= np.exp(-F * z); S.h3[i] *= np.exp(-2 * F * z)
        S.dos += k * of[0][:, None]; S.doc += k * of[1][:, None]; 
        S.u = S.u + k * 1e-6 * sk[:, None] * (S.amp - 1) * 20
    return {"elec": elec}, {"z_rms_m": z0}

def e_bvib(rng, hw, form, ns):
    m = int(rng.integers(1, 4)); f = np.exp(rng.uniform(np.log(6), np.log(150), m)); A = rng.uniform(.4, 1, m); dr = rng.uniform(0, 6.28, m); el = rng.uniform(-.4, .4, m); mod = rng.uniform(0, .35); fm = rng.uniform(.05, .4)
    def when(S, k):
        r = timerng(ns, S); t = S.T.t
        for j in range(m):
            ph = 2 * np.pi * f[j] * t + r.uniform(0, 6.28) ; a = 1e-6 * k * A[j] * (1 + mod * np.sin(2 * np.pi * fm * t + r.uniform(0, 6.28)))
            S.bx += a * (np.cos(dr[j]) * np.sin(ph) - el[j] * np.sin(dr[j]) * np.cos(ph)); S.by += a * (np.sin(dr[j]) * np.sin(ph) + el[j] * np.cos(dr[j]) * np.cos(ph))
    return {"when": when}, {"hz": f.tolist()}

def e_skew(rng, hw, form, ns):
    e, g = rng.normal(0, 1e-3, 2); e += .3e-3 * np.sign(e)
    def geom(S, k):
        for i in (1, 3): S.u[i] = S.u[i] * (1 + k * e) + k * g * S.w[i]
    return {"geom": geom}, {"pitch_difference": e, "out_of_square": g}

def e_slip(rng, hw, form, ns):
    i = 0 if form == "reference" else int(rng.integers(0, 4)); n = int(rng.choice([-3, -2, -1, 1, 2, 3], p=[.1, .15, .25, .25, .15, .1])); 
    def slip(S, k):   # a comparator misses an edge while the segment moves fast
        r = timerng(ns, S); N = S.N; lo, hi = int(.2 * N), int(.85 * N)
        sp = np.abs(S.vu[i][lo:hi]); c = np.flatnonzero(sp > 5e-3)
        j = lo + (int(r.choice(c)) if len(c) else int(r.integers(0, hi - lo))); S.slip[i, j:] += n
    return {"slip": slip}, {"segment": i + 1, "teeth": n}

def e_burst(rng, hw, form, ns):
    frac = np.exp(rng.uniform(np.log(.003), np.log(.03))); lo = rng.uniform(30, 55); hi = lo * rng.uniform(2, 5); shared = rng.random() < .4; m = some(rng, 1, 4); pd = rng.random() < .35 and hw["diode"]
    if form == "reference": m = np.array([1, 0, 0, 0.])
    def burst(S, k):  # relay and motor-drive transients: spikes or short rings
        r = timerng(ns, S); todo = int(frac * S.N)
        while todo > 0:
            n = int(min(r.integers(1, 8), todo)); j = int(r.integers(0, S.N - n)); t = np.arange(n); todo -= n
            env = np.exp(-t / r.uniform(2, 8)) * (np.cos(r.uniform(.3, 2.5) * t) if r.random() < .5 else 1)
            env = np.sign(env + 1e-9) * np.maximum(np.abs(env), .5)
            a = np.exp(r.uniform(np.log(lo), np.log(min(hi, 200)))) * r.choice([-1, 1])
            hit = m if shared else m * (np.arange(4) == r.choice(np.flatnonzero(m)))
            for i in np.flatnonzero(hit):
                an = r.uniform(0, 6.28); S.burst[:, i, j:j + n] += a * hw["qn"] * env * np.array([[np.cos(an)], [np.sin(an)]])
                S.pb[i, j:j + n] += a * hw["posn"] * env * r.choice([-1, 1])
            if pd: S.eb[int(r.integers(0, 4)), j:j + n] += a * hw["pn"] * env
    return {"burst": burst}, {"fraction": frac, "sigma": [lo, min(hi, 200)]}

def e_noise(rng, hw, form, ns):
    f = np.exp(rng.uniform(np.log(1.6), np.log(6))); w = rng.choice(["quad", "both", "psd"]) if hw["diode"] else "quad"
    def noise(S, k):
        if w != "psd": S.nf = f
        if w != "quad": S.nfp = f
    return {"noise": noise}, {"factor": f, "where": str(w)}

def e_clip(rng, hw, form, ns):
    ch = np.zeros((2, 4, 2)); 
    for i in np.flatnonzero(some(rng, 1, 3)):
        for j in ([0], [1], [0, 1])[int(rng.integers(0, 3))]: ch[j, i] = 1 if rng.random() < .5 else rng.uniform(.5, 1, 2)
    if form == "reference": ch[int(rng.integers(0, 2)), 0] = 1
    nk = rng.uniform(25, 90)
    def clipf(x, lo, hi):   # amplifier against its rails: a knee, then flat
        out = x.copy(); p = x > 0
        out[p] = x[p] / (1 + (x[p] / hi) ** nk) ** (1 / nk); q = ~p; out[q] = x[q] / (1 + (-x[q] / lo) ** nk) ** (1 / nk); return out
    def sig(S, k):
        for i in range(4):
            for j, a in ((0, S.s), (1, S.c)):
                if ch[j, i].any():
                    d = np.minimum(.08 * k * ch[j, i], .55); L = 1 - d; a[i] = clipf(a[i], L[0], L[1])
    return {"sig": sig}, {"channels": ch[:, :, 0].tolist(), "knee": nk}

def e_qdrift(rng, hw, form, ns):
    m = some(rng, 1, 4); wts = rng.dirichlet([1, 1, 1]); 
    if form == "reference": m[0] = 1
    amp = rng.uniform(.5, 1.5, (4, 4))
    def elec(S, k):   # amplifier and oscillator ageing, contact: random walk, smoothed, with a ramp
        r = timerng(ns, S); t = S.T.t; d = t[-1] - t[0]; g = np.linspace(t[0], t[-1], 200)
        def walk():
            w = np.convolve(np.cumsum(r.normal(0, 1, 220)), np.ones(21) / 21, "valid"); w = w - w.mean(); return np.interp(t, g, w / (w.std() + 1e-9))
        for i in np.flatnonzero(m):
            S.dos[i] += k * .006 * wts[0] * amp[0, i] * walk(); S.doc[i] += k * .006 * wts[0] * amp[1, i] * walk()
            S.dg[i] += k * .012 * wts[1] * amp[2, i] * walk(); S.dps[i] += k * .012 * wts[2] * amp[3, i] * walk()
    return {"elec": elec}, {"shares_offset_gain_phase": wts.tolist(), "pairs": m.tolist()}

def e_span(rng, hw, form, ns):
    e = rng.normal(0, 60e-6, 4) * some(rng, 1, 4); 
    if abs(e[0] + e[2] - e[1] - e[3]) < 40e-6: e[int(rng.integers(0, 4))] += 80e-6
    def build(S, k): S.esp = S.esp + k * e
    return {"build": build}, {"segment_m": e.tolist()}

CAT = {"lateral_dependence": e_lateral, "extra_harmonics": e_harm, "tooth_variation": e_tooth, "angle_dependence": e_angle,
       "psd_nonlinearity": e_psdnl, "psd_misalignment": e_psdmis, "thermal_drift": e_thermal, "velocity_lag": e_lag, "psd_latency": e_psdlat,
       "hysteresis": e_hyst, "gap_variation": e_gap, "beacon_vibration": e_bvib, "axis_skew": e_skew, "cycle_slip": e_slip,
       "outlier_bursts": e_burst, "excess_noise": e_noise, "adc_clipping": e_clip, "quadrature_drift": e_qdrift, "span_error": e_span}
NORMS = {"cycle_slip", "outlier_bursts", "excess_noise"}
NEED_DIODE = {"psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew"}
NOT_POS = {"gap_variation", "adc_clipping"}
REF_OK = {"extra_harmonics", "tooth_variation", "thermal_drift", "velocity_lag", "hysteresis", "gap_variation", "cycle_slip", "outlier_bursts", "excess_noise", "adc_clipping", "quadrature_drift"}

def can(name, form, diode):
    if form == "reference": return name in REF_OK
    if name == "lateral_dependence" and not diode: return False      # an exact enough alias of own phases without the diode
    if name in NEED_DIODE and not diode: return False
    return not (form == "positions" and name in NOT_POS)

# ------------------------------------------------------------------------------------------------ causes outside the catalogue

def first(rng, form, lo=1, hi=4):
    m = some(rng, lo, hi)
    if form == "reference": m = np.array([1, 0, 0, 0.])
    return m

def u_hum(rng, hw, form, ns):
    f = rng.choice([50., 60.]); f *= 1 + rng.normal(0, 4e-4); m = first(rng, form); h = rng.normal(0, .004, (2, 4, 2)) * m[None, :, None]; h[..., 0] += .003 * np.sign(h[..., 0])
    def sig(S, k):
        r = timerng(ns, S); p0 = r.uniform(0, 6.28); t = S.T.t
        for j, a in ((0, S.s), (1, S.c)): a += k * (h[j, :, 0, None] * np.sin(2 * np.pi * f * t + p0) + .4 * h[j, :, 1, None] * np.sin(6 * np.pi * f * t + p0))
    return {"sig": sig}, {"hz": f}
def u_ambient(rng, hw, form, ns):
    ax, ay = rng.uniform(-1, 1, 2) * .9
    def elec_psd(S, k):
        r = timerng(ns, S); t = S.T.t; on = np.zeros(S.N); d = t[-1] - t[0]; tb = t[S.T.psd]
        x = float(r.uniform(.1, .3)) * 0 + tb[0]; state = 0
        while x < t[-1]:
            x2 = x + (tb[-1] - tb[0]) * r.uniform(.06, .25); 
            if state: on += ((t > x) & (t < x2)) * (1 - np.exp(-(np.clip(t - x, 0, None)) / .02))
            state ^= 1; x = x2
        b = k * .004 * S.hw["S"] * on
        S.el = S.el + np.array([b / 2 * (1 + ax), b / 2 * (1 - ax), b / 2 * (1 + ay), b / 2 * (1 - ay)])
    return {"elec_psd": elec_psd}, {"at": [ax, ay]}
def u_drive(rng, hw, form, ns):
    f = rng.uniform(0, 6.28, (2, 4)); m = first(rng, form, 2, 4); sp = rng.uniform(20, 60)
    def sig(S, k):   # stray field of the motor's phase currents, of size as the force: inertia plus umbilical spring
        t = S.T.t
        x, y = S.T.q[0], S.T.q[1]
        for i in range(4):
            j = i % 2; frc = np.abs(S.T.a[j]) + sp * np.abs(S.T.q[j] - 5e-3) * (1 + 0 * t)
            ang = F * S.T.q[j] + np.sign(S.T.a[j] + 1e-12) * 0
            S.s[i] += k * m[i] * .006 * frc * np.sin(ang + f[0, i]); S.c[i] += k * m[i] * .006 * frc * np.cos(ang + f[1, i])
    return {"sig": sig}, {}
def u_mast(rng, hw, form, ns):
    g = rng.uniform(.6, 1.4, 2) * 1e-6
    def c(S, k):     # the mast that carries the diode bends with acceleration
        ax = np.cos(S.th) * S.T.a[0] + np.sin(S.th) * S.T.a[1]; ay = -np.sin(S.th) * S.T.a[0] + np.cos(S.th) * S.T.a[1]
        S.cx = S.cx - k * g[0] * ax; S.cy = S.cy - k * g[1] * ay
    return {"c": c}, {}
def u_creep(rng, hw, form, ns):
    a = rng.normal(0, 2e-6, 2); bump = rng.random() < .5
    def when(S, k):  # overhead manipulator relaxes after being clamped, or is knocked
        r = timerng(ns, S); t = S.T.t; tb = t[S.T.psd]; d = tb[-1] - tb[0]
        t1 = tb[0] + d * r.uniform(.2, .7) if bump else tb[0] - r.uniform(2, 10); s = np.clip(t - t1, 0, None)
        sh = (s > 0) * (1 - .4 * np.exp(-s / (d * .1))) if bump else np.log1p(s / (d * .03))
        S.bx += k * a[0] * sh; S.by += k * a[1] * sh
    return {"when": when}, {"knock": bool(bump)}
def u_xtalk(rng, hw, form, ns):
    prs = [(0, 1), (1, 2), (2, 3), (3, 0)]; pick = rng.choice(4, int(rng.integers(1, 4)), replace=False); kk = rng.normal(0, .008, (4, 2, 2))
    def sig(S, k):   # neighbouring pairs share a cable: a part of the other pair's voltages
        s, c = S.s.copy(), S.c.copy()
        for n in pick:
            i, j = prs[n]; S.s[i] += k * (kk[n, 0, 0] * s[j] + kk[n, 0, 1] * c[j]); S.c[i] += k * (kk[n, 1, 0] * s[j] + kk[n, 1, 1] * c[j])
    return {"sig": sig}, {"pairs": [prs[n] for n in pick]}
def u_jitter(rng, hw, form, ns):
    m = first(rng, form, 1, 3)
    def elec(S, k):  # conversion start of one converter waits for a busy bus: random delay about a trimmed mean
        r = timerng(ns, S); d = (r.gamma(1.3, 1, (4, S.N)) - 1.3) * 40e-6; S.u = S.u - k * m[:, None] * d * S.vu
    return {"elec": elec}, {"segments": m.tolist()}
def u_quant(rng, hw, form, ns):
    m = some(rng, 2, 4)
    def interp(S, k):  # interpolator chip of few steps a tooth
        q = RHO / np.maximum(4, np.round(RHO / (k * 2.5e-6)))
        S.p = np.where(m[:, None] > 0, (np.floor(S.p / q) + .5) * q, S.p)
    return {"interp": interp}, {"segments": m.tolist()}
def u_bracket(rng, hw, form, ns):
    g = rng.normal(0, 1e-6, 4) * first(rng, form, 1, 3); g += .5e-6 * np.sign(g); cr = rng.normal(0, .4, 4)
    def geom(S, k):    # a segment's bracket yields under the courier's acceleration
        for i in range(4): S.u[i] = S.u[i] - k * g[i] * (S.au[i] + cr[i] * S.T.a[1 - i % 2])
    return {"geom": geom}, {"m_per_m_s2": g.tolist()}
def u_segvib(rng, hw, form, ns):
    m = first(rng, form, 1, 2); f = np.exp(rng.uniform(np.log(12), np.log(140)))
    def geom(S, k):    # fan shakes one segment's bracket
        r = timerng(ns, S); t = S.T.t; ph = 2 * np.pi * f * t + r.uniform(0, 6.28) + wander(r, t / 10, .6)
        S.u = S.u + k * 1e-6 * m[:, None] * np.sin(ph) * (1 + .2 * np.sin(.3 * t))
    return {"geom": geom}, {"hz": f, "segments": m.tolist()}
def u_dark(rng, hw, form, ns):
    d = rng.normal(0, 60, 4)
    def elec_psd(S, k):  # leakage in the electrodes stays while the beacon's supply sags
        r = timerng(ns, S); t = S.T.t; tb = t[S.T.psd]; d0 = tb[-1] - tb[0]; x = (t - tb[0]) / d0
        b = .72 + .2 * np.sin(2 * np.pi * x * r.uniform(2, 5) + r.uniform(0, 6.28)) + .06 * np.sin(2 * np.pi * x * r.uniform(6, 14))
        S.el = S.el * b + k * d[:, None]
    return {"elec_psd": elec_psd}, {}
def u_glint(rng, hw, form, ns):
    th0 = rng.uniform(-1, 1) * .014; wd = rng.uniform(.15, .45) * np.pi / 180; gx, gy = rng.uniform(-.9, .9, 2); gx += .3 * np.sign(gx); gy += .3 * np.sign(gy)
    def elec_psd(S, k):  # a bright edge of the courier mirrors the beacon into the lens at one heading
        b = k * .004 * S.hw["S"] * np.exp(-.5 * ((S.th - th0) / wd) ** 2); S.el = S.el + np.array([b / 2 * (1 + gx), b / 2 * (1 - gx), b / 2 * (1 + gy), b / 2 * (1 - gy)])
    return {"elec_psd": elec_psd}, {"at_rad": th0, "width": wd}
def u_beat(rng, hw, form, ns):
    df = np.exp(rng.uniform(np.log(.7), np.log(25))); kk = rng.normal(0, .006, (2, 4)); kk += .003 * np.sign(kk)
    def sig(S, k):       # two drive oscillators not locked: the neighbour's carrier is demodulated to a beat
        r = timerng(ns, S); t = S.T.t; ph = 2 * np.pi * df * t + r.uniform(0, 6.28); s, c = S.s.copy(), S.c.copy()
        for i in range(4):
            j = (i + 1) % 4; S.s[i] += k * kk[0, i] * (.5 + .5 * s[j]) * np.cos(ph); S.c[i] += k * kk[1, i] * (.5 + .5 * c[j]) * np.cos(ph + .4)
    return {"sig": sig}, {"hz": df}
def u_loose(rng, hw, form, ns):
    i = 0 if form == "reference" else int(rng.integers(0, 4)); a = rng.choice([-1, 1]) * 2e-6
    def geom(S, k):      # a screw lets go: the segment jumps by microns, once or twice, at hard stops
        r = timerng(ns, S); t = S.T.t; pb = S.T.psd.any(); ref = t[S.T.psd] if pb else t; d = ref[-1] - ref[0]
        for fr, w in ((r.uniform(.15, .5), 1), (r.uniform(.55, .85), r.uniform(-1, .6))): S.u[i] = S.u[i] + k * a * w * (t > ref[0] + d * fr)
    return {"geom": geom}, {"segment": i + 1}
def u_turb(rng, hw, form, ns):
    def when(S, k):      # warm air in the beam: random walk-like image dancing, f^-1.5 from 0.3 to 30 Hz
        r = timerng(ns, S); t = S.T.t
        for b in ("bx", "by"):
            o = np.zeros(S.N)
            for f in np.exp(r.uniform(np.log(.2), np.log(30), 60)): o += (f + .3) ** -.45 * np.sin(2 * np.pi * f * t + r.uniform(0, 6.28))
            setattr(S, b, getattr(S, b) + k * 3e-7 * o)
    return {"when": when}, {}
def u_ground(rng, hw, form, ns):
    kk = rng.normal(0, .004, (2, 4)) * first(rng, form, 2, 4); kk += .002 * np.sign(kk)
    def sig(S, k):       # drive amplifiers' return current rises with speed and lifts the signal ground
        sp = np.hypot(S.T.v[0], S.T.v[1]) / 50e-3; sp = sp ** 2 / (sp + .3)
        S.s += k * kk[0][:, None] * sp; S.c += k * kk[1][:, None] * sp
    return {"sig": sig}, {}
def u_neigh(rng, hw, form, ns):
    X, Y = rng.uniform(2e-3, 9e-3, 2) + rng.choice([-1, 1], 2) * rng.uniform(2e-3, 10e-3, 2); f = np.exp(rng.uniform(np.log(20), np.log(150))); kk = rng.normal(0, .01, (2, 4))
    def sig(S, k):       # another courier parked near by: its motor's alternating field, falling with the third power of distance
        r = timerng(ns, S); ph = 2 * np.pi * f * S.T.t + r.uniform(0, 6.28)
        d = np.sqrt((S.T.q[0] - X) ** 2 + (S.T.q[1] - Y) ** 2 + (8e-3) ** 2); b = k * (8e-3 / d) ** 3 * np.sin(ph)
        S.s += kk[0][:, None] * b; S.c += kk[1][:, None] * b
    return {"sig": sig}, {"hz": f, "at": [X, Y]}

OT, LT, TH, PL, DF, SP, DI, TI, FR, TE, AM = "own tooth phase", "lateral tooth phase", "theta|angle", "place|platen", "deflection", "speed", "direction", "time", "frequency|vibration", "temperature", "amplitude"
#  key: builder, description, places, needs diode, forms
UNL = {
 "hum": (u_hum, "mains hum picked up in the sine and cosine leads", [FR, TI, OT], 0, "beacon nobeacon positions reference"),
 "ambient": (u_ambient, "room lamp switched on and off shines on the diode", [TI, DF], 1, "beacon positions"),
 "drive": (u_drive, "stray field of the motor currents, growing with force, at the pitch phase", [OT, PL, SP, TI], 0, "beacon nobeacon reference"),
 "mast": (u_mast, "mast of the diode bends with acceleration", [SP, TI, DI, DF, FR], 1, "beacon positions"),
 "creep": (u_creep, "overhead beacon creeps or is knocked out of place", [TI], 1, "beacon positions"),
 "xtalk": (u_xtalk, "electrical crosstalk from a neighbouring perpendicular pair", [OT, LT], 0, "beacon nobeacon positions"),
 "jitter": (u_jitter, "random conversion-start jitter of a segment's converter", [SP, TI], 0, "beacon nobeacon reference positions"),
 "quant": (u_quant, "interpolator of few steps a tooth", [OT], 0, "positions"),
 "bracket": (u_bracket, "segment bracket bends with acceleration", [SP, TI, DI, FR], 0, "beacon nobeacon reference"),
 "segvib": (u_segvib, "a fan shakes one segment's bracket", [FR, TI], 0, "beacon nobeacon positions reference"),
 "dark": (u_dark, "electrode leakage while the beacon's brightness varies", [TI, AM, DF], 1, "beacon"),
 "glint": (u_glint, "a mirror glint of the beacon at one heading", [TH, DF], 1, "beacon positions"),
 "beat": (u_beat, "beat of unlocked drive oscillators between neighbouring pairs", [FR, TI, OT, LT], 0, "beacon nobeacon"),
 "loose": (u_loose, "a loose segment jumps by microns in its mount", [TI], 0, "beacon nobeacon positions reference"),
 "turb": (u_turb, "air turbulence in the beacon's path", [TI, FR], 1, "beacon"),
 "ground": (u_ground, "signal ground lifted by the drives' return current as speed rises", [SP, OT], 0, "beacon nobeacon reference"),
 "neigh": (u_neigh, "alternating field of a neighbouring courier's motor", [FR, PL, TI, OT], 0, "beacon nobeacon"),
}

# ------------------------------------------------------------------------------------------------ cases

FORMS60 = ["beacon"] * 36 + ["nobeacon"] * 9 + ["positions"] * 9 + ["reference"] * 6

def plan(K):
    """the three sets are planned together, so that names and pairs spread"""
    R = np.random.default_rng(20260417); names = list(CAT); out = []; used = set(); ucount = {u: 0 for u in UNL}
    cnt2 = {n: 0 for n in names}
    ones = names * 3 + list(R.choice(names, 6, replace=False)); 
    ones = [ones[i::3] for i in range(3)]
    for s in range(3):
        kinds = ["one"] * 21 + ["two"] * 18 + ["none"] * 7 + ["unlisted"] * 14
        forms = list(R.permutation(FORMS60)); ds = {"beacon": True, "nobeacon": False, "reference": False}
        slots = [(f, ds.get(f, None)) for f in forms]; slots = [(f, bool(R.random() < .55) if d is None else d) for f, d in slots]
        cases = []
        def take(ok):
            idx = [i for i, sl in enumerate(slots) if ok(*sl)]
            return slots.pop(int(R.choice(idx))) if idx else None
        # 'quant' and a few others first, then those with the greatest need
        uset = sorted(UNL, key=lambda u: (ucount[u], R.random()))[:14]
        for u in uset: ucount[u] += 1
        work = [("one", [n]) for n in ones[s]]
        uw = []
        for u in uset: uw.append(("unlisted", [u]))
        tmp = sorted(work + uw, key=lambda w: (0 if w[1][0] == "quant" else 1, R.random()))
        # leave a fair share of each form to 'two' and 'none'
        quota = {"beacon": 21, "nobeacon": 6, "positions": 5, "reference": 3}; got = {k: 0 for k in quota}
        for kind, ns in tmp:
            def ok(f, d):
                if got[f] >= quota[f]: return False
                if kind == "one": return can(ns[0], f, d)
                b = UNL[ns[0]]; return f in b[4].split() and (d or not b[3])
            sl = take(ok)
            if sl is None:
                q0 = dict(quota); quota = {k: 99 for k in quota}; sl = take(ok); quota = q0
            got[sl[0]] += 1; cases.append((kind, ns, sl))
        for _ in range(7): cases.append(("none", [], slots.pop(int(R.integers(0, len(slots))))))
        for sl in slots:
            best = None
            for _ in range(300):
                a, b = R.choice(names, 2, replace=False); a, b = sorted((str(a), str(b)))
                if (a, b) in used or not (can(a, *sl) and can(b, *sl)): continue
                if {a, b} in ({"psd_misalignment", "axis_skew"}, {"excess_noise", "outlier_bursts"}, {"psd_latency", "velocity_lag"}, {"adc_clipping", "extra_harmonics"}): continue
                sc = cnt2[a] + cnt2[b] + R.random()
                if best is None or sc < best[0]: best = (sc, a, b)
            _, a, b = best; used.add((a, b)); cnt2[a] += 1; cnt2[b] += 1; cases.append(("two", [a, b], sl))
        cases = [cases[i] for i in R.permutation(len(cases))]
        out.append(cases)
    return out[K - 1]

CAPS = {"lateral_dependence": 15, "tooth_variation": 4, "angle_dependence": 10, "mast": 55, "span_error": 6, "gap_variation": 5}   # no strength that nobody would build

def scale(hw, form, T, hk, target, power=1.0):
    base = size(hw, form, T, [], 3); k = 1.0; lo = hi = None
    for it in range(14):
        r = size(hw, form, T, [(hk, k)], 3); m = max(np.sqrt(max(0, r[c] ** 2 - base[c] ** 2)) for c in r)
        if abs(m / target - 1) < .02: break
        if m < target: lo = k
        else: hi = k
        kn = k * np.clip((target / max(m, 1e-9)) ** power, .1, 8)
        if lo and hi and not (min(lo, hi) < kn < max(lo, hi)): kn = np.sqrt(lo * hi)
        if lo and hi and it > 7: kn = np.sqrt(lo * hi)
        k = float(kn)
    return k, m

def write(dirn, hw, form, T, S, rng, ids):
    os.makedirs(dirn, exist_ok=True); L = np.flatnonzero(T.log); o = []
    ref = form == "reference"; cnt = form != "positions"
    o += ["schema = 1", 'device = "courier %s"' % ids, 'source = "board recorder"', "", "[geometry]", "pitch_m = %.6g" % RHO]
    if not ref or True: o += ["span_m = %.6g" % hw["ls"], "lateral_m = %.6g" % hw["lo_nom"]]
    o.append("")
    if hw["diode"]: o += ["[coordination]", "height_m = %.6g" % hw["hn"], "lever_x_m = %.6g" % hw["lxn"], "lever_y_m = %.6g" % hw["lyn"], "tan_full_scale = %.8g" % hw["tfs"], ""]
    o.append("[electronics]")
    if cnt: o += ["adc_bits = 16", "amplitude_counts = %.1f" % hw["A0"], "quadrature_noise_counts = %.2f" % hw["qn"]]
    else: o.append("position_noise_m = %.4g" % hw["posn"])
    if hw["diode"]: o += ["psd_sum_counts = %.1f" % hw["S"], "psd_noise_counts = %.2f" % hw["pn"]]
    open(dirn + "/recording.toml", "w").write("\n".join(o) + "\n")
    N = len(L); t = np.round(T.t[L] + rng.normal(0, 1.5e-6, N), 6); t = np.maximum.accumulate(t)
    for i in np.flatnonzero(np.diff(t) <= 0): t[i + 1] = round(t[i] + 1e-6, 6)
    cols = [("t_s", ["%.6f" % v for v in t]), ("run", T.name[L].tolist())]
    segs = (0,) if ref else range(4)
    if cnt:
        for i in segs: cols += [("q%ds" % (i + 1), map(str, S.Qs[i, L].tolist())), ("q%dc" % (i + 1), map(str, S.Qc[i, L].tolist())), ("n%d" % (i + 1), map(str, S.n[i, L].tolist()))]
    else:
        for i in segs: cols.append(("p%d_m" % (i + 1), ["%.9f" % v for v in S.P[i, L]]))
    if hw["diode"]:
        sn = T.psd[L]; zero = rng.random() < .5
        for j, nm in enumerate(("psd_xp", "psd_xn", "psd_yp", "psd_yn")):
            cols.append((nm, [str(v) if b else ("0" if zero else "") for v, b in zip(S.E[j, L].tolist(), sn)]))
    tr = hw["tres"]; cols.append(("temp_c", ["%.4f" % v for v in np.round((T.T[L] + rng.normal(0, .02, N)) / tr) * tr]))
    q = T.q[:, L]; jump = np.concatenate([[True], np.diff(T.t[L]) > 10 / T.fs]); gid = np.cumsum(jump) - 1
    pe = rng.normal(0, 1, (3, gid[-1] + 1)) * np.array([15e-6, 15e-6, 2.5e-4])[:, None]
    cm = [q[j] + pe[j][gid] + (20e-6 * np.sin(F * q[j] + j) if j < 2 else 0) for j in range(3)]
    cols += [("cmd_x_m", ["%.6f" % v for v in cm[0]]), ("cmd_y_m", ["%.6f" % v for v in cm[1]]), ("cmd_theta_rad", ["%.6f" % v for v in cm[2]])]
    if ref: cols.append(("ref_x_m", ["%.9f" % v for v in S.u_true[0][L] + rng.normal(0, hw["refn"], N)]))
    with open(dirn + "/samples.csv", "w") as fh:
        fh.write(",".join(c[0] for c in cols) + "\n"); fh.write("\n".join(map(",".join, zip(*[c[1] for c in cols]))) + "\n")

def make_case(K, ci, case, out):
    kind, ns, (form, diode) = case; seed = 1000003 * K + 7919 * ci + 13
    rng = np.random.default_rng([seed, 1]); hw = hardware(rng, form, ns, diode)
    hw["lo_nom"] = round(hw["lo"] + rng.uniform(-3e-6, 3e-6), 6); hw["tres"] = float(rng.choice([.01, .0625, .05])); hw["refn"] = .05e-6 * rng.uniform(.85, 1.15)
    if ns and (ns[0] in ("segvib", "neigh", "hum") or "beacon_vibration" in ns): hw["fs"] = float(rng.choice([400, 500]))
    T1, T2 = trajectory(seed, hw, form, 1), trajectory(seed, hw, form, 2)
    effs, par, tot = [], {}, []
    for j, n in enumerate(ns):
        b = UNL[n][0] if kind == "unlisted" else CAT[n]
        for tr in range(14):
            r = np.random.default_rng([seed, 100 + j, tr]); es = seed + 31 * j + 1009 * tr
            hk, pr = b(r, hw, form, es); target = float(np.exp(r.uniform(np.log(.7e-6), np.log(4e-6)))); k = 1.0; m = 0
            if n in NORMS: break
            k, m = scale(hw, form, T1, hk, target, .7 if n == "adc_clipping" else 1.0)
            if abs(m / target - 1) < .1 and k <= CAPS.get(n, 1e9): break
        else: print("  scale missed", ci, n, form, m, target, k)
        effs.append((hk, k)); par[n] = {"strength": k, "rms_m": m, **pr}; tot.append(m)
    fin = {}
    d = "%s/c%03d" % (out, ci)
    for T, nm in ((T1, "first"), (T2, "second")):
        S = simulate(hw, T, effs, np.random.default_rng([seed, 500, T.rec]), form)
        write(d + "/" + nm, hw, form, T, S, np.random.default_rng([seed, 600, T.rec]), "%03d" % (seed % 997))
        if n_check: fin[nm] = check(hw, form, T, S, kind)
    un = UNL[ns[0]] if kind == "unlisted" else None
    return {"case": "c%03d" % ci, "kind": kind, "form": form, "effects": ns if kind in ("one", "two") else [], "unlisted": un[1] if un else None,
            "places": un[2] if un else [], "params": json.loads(json.dumps(par, default=lambda o: o.tolist() if hasattr(o, "tolist") else str(o))), "rms_m": max(tot) if tot else 0.0}, fin

n_check = False
def check(hw, form, T, S, kind):
    L = T.log; pn = (np.arctan2(S.Qs, S.Qc) / F + S.n * RHO) if form != "positions" else S.P
    r = fit_residual(hw, form, pn[:, L], S.E[:, L].astype(float), T.psd[L], S.u_true[0][L], 1)
    r0 = fit_residual(hw, form, S.pm[:, L], S.el[:, L], T.psd[L], S.u_true[0][L], 1)
    sq = hw["posn"] if form == "positions" else np.mean(np.hypot(hw["qn"], .289) / hw["A"] / F)
    sth = sq / hw["ls"]; sc = hw["h"] * hw["tfs"] * np.hypot(hw["pn"], .289) * 1.414 / hw["S"]
    ex = {"g_p": 2 * sq, "segment_1": sq, "g_x": np.hypot(sc, np.hypot(sq * .707, sth * hw["ly"])), "g_y": np.hypot(sc, np.hypot(sq * .707, sth * hw["lx"]))}
    rail = max(np.abs(S.Qs[:, L]).max() if form != "positions" else 0, np.abs(S.Qc[:, L]).max() if form != "positions" else 0, S.E[:, L & T.psd].max() if T.psd.any() else 0)
    return {"N": int(L.sum()), "dur": round(float(T.t[-1])), "rail": int(rail), **{c: "%.2f=%.2f~%.2f" % (rms(r[c]) * 1e6, rms(r0[c]) * 1e6, ex[c] * 1e6) for c in r}}

def main():
    global n_check
    ap = argparse.ArgumentParser(); ap.add_argument("--set", type=int, required=True); ap.add_argument("--out", required=True); ap.add_argument("--check", action="store_true"); ap.add_argument("--only", default="")
    a = ap.parse_args(); n_check = a.check; truth = []
    os.makedirs(a.out, exist_ok=True)
    only = [int(v) for v in a.only.split(",")] if a.only else None
    for ci, case in enumerate(plan(a.set)):
        if only and ci not in only: continue
        tr, fin = make_case(a.set, ci, case, a.out); truth.append(tr)
        if a.check: print(ci, case[0], case[1], case[2], "%.2f" % (tr["rms_m"] * 1e6)); [print("    ", k, v) for k, v in fin.items()]
    json.dump(truth, open(a.out + "/truth.json", "w"), indent=1)

if __name__ == "__main__":
    main()
