"""An independent simulator of a courier's sensors, by the ways of a workshop: python make.py --set K --out DIR"""
import os
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import sys, json, argparse
import numpy as np
RHO = 1.016e-3
F = 2*np.pi/RHO
SG = np.array([1., 1., -1., -1.])          # sign of (l_s/2)*theta in p1..p4
LG = np.array([-1., 1., 1., -1.])          # sign of l_o*theta in the lateral coordinate
DT = 5e-4                                  # dense grid of a move
def lu(r, a, b): return float(np.exp(r.uniform(np.log(a), np.log(b))))
def pm(r, a, b, n=None): return r.uniform(a, b, n)*r.choice([-1, 1], n)

# ------------------------------------------------------------------ motion
def profile(D, v, a, kind, jerk_t):
    """distance along a move against time on the dense grid; trapezoid or S-curve (boxcar-smoothed velocity)"""
    v = min(v, np.sqrt(a*D)); T = D/v + v/a
    t = np.arange(0, T + DT, DT)
    vel = np.clip(np.minimum(a*t, a*(T - t)), 0, v)
    if kind == "s":
        w = np.ones(max(2, int(jerk_t/DT))); vel = np.convolve(vel, w/len(w))
    s = np.concatenate([[0], np.cumsum((vel[1:] + vel[:-1])/2)*DT])
    return s*D/s[-1]
class Run:
    pass
class Motion:
    """pose as a function of time for the list of runs; beacon flag per sample"""
    def __init__(self, case, seed):
        self.seed = seed; r = self.r = np.random.default_rng(seed); self.case = case
        self.fs = case.fs; self.runs = []
        self.t = 0.0
        f = case.form
        x0, y0 = case.area
        thb = r.uniform(-1, 1)*1e-3
        todo = []
        acc = lu(r, 0.8, 5.0); kind = r.choice(["t", "s"]); jt = r.uniform(0.01, 0.05)
        self.acc, self.kind, self.jt = acc, kind, jt
        if f == "reference":
            L = r.uniform(0.042, 0.052); spd = sorted([lu(r, 0.006, 0.014), lu(r, 0.03, 0.07)])
            for v, nm in ((spd[0], "pass_slow"), (spd[1], "pass_fast"), (lu(r, 0.015, 0.03), "pass_mid"))[:r.integers(2, 4)]:
                todo.append(lambda v=v, nm=nm: self.line(nm, (x0, y0, 0), (x0+L, y0, 0), v))
                todo.append(lambda v=v, nm=nm: self.line(nm+"_back", (x0+L, y0, 0), (x0, y0, 0), v))
            n = r.integers(350, 700)
            todo.append(lambda: self.stills("scatter", np.c_[x0+r.uniform(0, L, n), np.full(n, y0)+r.uniform(-2e-6, 2e-6, n), np.zeros(n)], False))
            todo.append(lambda: self.line("still", (x0+.4*L, y0, 0), (x0+.4*L, y0, 0), 0))
            if r.random() < .5: todo.append(lambda: self.jog("jog", (x0+.01, y0, 0), (0.02, 0, 0), False))
        else:
            n = r.integers(350, 750); tr = np.deg2rad(0.5)
            todo.append(lambda: self.stills("scatter", np.c_[x0+r.uniform(0, 10*RHO, n), y0+r.uniform(0, 10*RHO, n), r.uniform(-tr, tr, n)], False))
            a = lambda lo=-.4, hi=.4: np.deg2rad(r.uniform(lo, hi))
            for ax in "xy":
                for back in (0, 1):
                    def fl(ax=ax, back=back):
                        la = r.uniform(0, 10*RHO); s = -0.015 + r.uniform(-2e-3, 2e-3); th = a()
                        p = [(x0+s, y0+la, th), (x0+s+.04, y0+la, th)] if ax == "x" else [(x0+la, y0+s, th), (x0+la, y0+s+.04, th)]
                        self.line(f"flyby_{ax}"+("_back" if back else ""), p[back], p[1-back], 0.05*r.uniform(.9, 1.1))
                    todo.append(fl)
            def slow(ax="y"):
                la = r.uniform(0, 10*RHO); th = a(); L = r.uniform(.025, .04); b = [(x0+la, y0-.012, th), (x0+la, y0-.012+L, th)]
                if r.random() < .4: b = b[::-1]
                self.line("flyby_y_slow", b[0], b[1], lu(r, .009, .02))
            todo.append(slow)
            if f == "nobeacon" or not case.diode:
                todo.append(lambda: self.spin("spin", (x0+.004, y0+.004), np.deg2rad(1.2)*r.uniform(.8, 1), False))
                todo.append(lambda: self.line("still", (x0+.003, y0+.002, 0), (x0+.003, y0+.002, 0), 0))
                m = r.integers(200, 400); t2 = np.deg2rad(1.4)
                todo.append(lambda: self.stills("scatter_wide", np.c_[x0+r.uniform(0, 10*RHO, m), y0+r.uniform(0, 10*RHO, m), r.uniform(-t2, t2, m)], False))
            else:
                m = r.integers(350, 700)
                def bea():
                    th = np.deg2rad(r.uniform(-1.5, 1.5, m)); c = r.uniform(-RHO, RHO, (m, 2))
                    self.stills("beacon", np.c_[case.body2p(th, c), th], True)
                todo.append(bea)
                for ax in (0, 1):
                    for back in (0, 1):
                        def bp(ax=ax, back=back):
                            th = np.deg2rad(r.uniform(-.6, .6)); e = r.uniform(-.7e-3, .7e-3)
                            c0 = np.array([[-.004, e], [.004, e]]); c0 = c0[:, ::-1] if ax else c0
                            if back: c0 = c0[::-1]
                            q = case.body2p(np.full(2, th), c0)
                            self.line("beacon_"+"xy"[ax]+("_back" if back else ""), (*q[0], th), (*q[1], th), .02*r.uniform(.85, 1.15), True)
                        todo.append(bp)
                todo.append(lambda: self.spin("spin", None, np.deg2rad(1.2)*r.uniform(.85, 1), True))
                q = case.body2p(np.zeros(1), r.uniform(-5e-4, 5e-4, (1, 2)))[0]
                todo.append(lambda: self.line("still", (*q, 0), (*q, 0), 0, True))
                if r.random() < .5: todo.append(lambda: self.jog("jog_beacon", (*q, 0), (2e-3, 2e-3, .01), True))
            if r.random() < .5: todo.append(lambda: self.jog("jog", (x0+.005, y0+.005, 0), (4e-3, 4e-3, .006), False))
        if r.random() < .6: r.shuffle(todo)
        self.pause = lu(r, 4, 40) if not case.hot else lu(r, 50, 180)
        for k in todo:
            self.t += self.pause*r.uniform(.3, 1.7); k()
        # join
        self.ts = np.concatenate([u.ts for u in self.runs]); self.N = len(self.ts)
        self.names = np.concatenate([[u.name]*len(u.ts) for u in self.runs])
        self.seen = np.concatenate([np.full(len(u.ts), u.seen) for u in self.runs])
        self.still = np.concatenate([np.full(len(u.ts), u.still) for u in self.runs])
        self.P0 = self.pose(0)
        self.V = (self.pose(1e-3) - self.pose(-1e-3))/2e-3
        self.A = (self.pose(4e-3) - 2*self.P0 + self.pose(-4e-3))/1.6e-5
        stamp = np.round(self.ts + r.uniform(-3e-6, 3e-6, self.N) + r.uniform(0, 50), 6)
        self.stamp = stamp
        T = self.ts[-1]; z = self.ts/T
        # board temperature: warm-up, day, fan switching
        A = r.uniform(9, 15) if case.hot else r.uniform(.5, 5)
        sh = r.integers(3)
        if sh == 0: g = (1 - np.exp(-z/r.uniform(.2, .6)))
        elif sh == 1: g = np.sin(np.pi*np.clip(z*r.uniform(.9, 1.6), 0, 2))
        else: g = np.where(z < .5, 1-np.exp(-z/.15), np.exp(-(z-.5)/.2)*(1-np.exp(-.5/.15)))
        g = g/np.ptp(g) if np.ptp(g) > 0 else g
        self.temp = r.uniform(22, 30) + r.choice([-1, 1], p=[.25, .75])*A*g + .15*np.sin(40*z+1)
        self.temp_read = np.round((self.temp + .03*r.standard_normal(self.N))/.0625)*.0625
        e = r.uniform(-30e-6, 30e-6, 3)*np.array([1, 1, 10])
        w = np.sin(self.P0[:, :2]*F/4 + r.uniform(0, 6, 2))*r.uniform(5e-6, 30e-6, 2)
        self.cmd = self.P0 + e + np.c_[w, 1.5e-4*np.sin(90*(self.P0[:, 0]-self.P0[:, 1]))]
    def add(self, name, seen, D, still=False, extra=None):
        u = Run(); u.name, u.seen, u.still = name, seen, still; r = self.r
        lead = r.uniform(.05, .12); T = len(D)*DT + 2*lead
        u.t0 = self.t + lead; u.D = D
        n = int(T*self.fs); u.ts = self.t + (np.arange(n) + r.random())/self.fs
        self.t += T; self.runs.append(u)
    def line(self, name, a, b, v, seen=False):
        r = self.r; a, b = np.array(a, float), np.array(b, float)
        if v == 0: D = np.tile(a, (int(r.uniform(.6, 1.2)/DT), 1))
        else:
            L = np.linalg.norm((b-a)[:2]); s = profile(L, v, self.acc, self.kind, self.jt)
            D = a + (b-a)*(s/L)[:, None]; D[:] = D
            sgn = np.array((b-a)[1] if abs((b-a)[1]) > abs((b-a)[0]) else (b-a)[0])
            D[:, :2] += r.uniform(0, 2e-6)*np.sin(F*s + r.uniform(0, 6))[:, None]*np.minimum(1, np.minimum(s, L-s)/1e-3)[:, None]
            if self.case.form != "reference":
                D[:, 2] += r.uniform(-1.5e-4, 1.5e-4)*np.sin(np.pi*s/L*r.uniform(1, 4))
        self.add(name, seen, D)
    def spin(self, name, ctr, amp, seen):
        r = self.r; T = r.uniform(1.6, 3); t = np.arange(0, T, DT); z = t/T
        th = amp*np.sin(2*np.pi*(z**3*(10-15*z+6*z*z)))
        if seen: xy = self.case.body2p(th, np.tile(r.uniform(-4e-4, 4e-4, 2), (len(t), 1)))
        else: xy = np.tile(ctr, (len(t), 1)) + 2e-5*np.c_[np.sin(3*z), np.cos(2*z)]
        self.add(name, seen, np.c_[xy, th])
    def jog(self, name, ctr, rg, seen):
        """a hand on the jog box: uneven pushes with pauses"""
        r = self.r; p = np.array(ctr, float); out = []; rg = np.array(rg); c = p.copy()
        for _ in range(r.integers(5, 9)):
            q = c + rg*r.uniform(-1, 1, 3); m = r.choice([0, 1, 2, 3]) if rg[1] > 0 else 0
            if m < 3: qq = p.copy(); qq[m] = q[m]; q = qq
            if seen:                                     # keep the diode under the beacon
                th = q[2]; k = self.case.p2body(np.r_[q, ][None, :])[0]
                q[:2] = self.case.body2p(np.array([th]), np.clip(k, -3e-3, 3e-3)[None, :])[0]
            d = np.linalg.norm((q-p)[:2]) + abs(q[2]-p[2])*.05
            n = int(max(.06, d/lu(r, .01, .05))/DT); z = np.linspace(0, 1, n); z = z**3*(10-15*z+6*z*z)
            out += [p + (q-p)*z[:, None], np.tile(q, (int(r.uniform(.02, .2)/DT), 1))]; p = q
        self.add(name, seen, np.concatenate(out))
    def stills(self, name, P, seen):
        r = self.r; k = self.case.per_pose; n = len(P); u = Run(); u.name, u.seen, u.still = name, seen, True
        dw = lu(r, .2, .8)
        tp = self.t + np.cumsum(dw*r.uniform(.7, 1.4, n))
        u.ts = (tp[:, None] + np.arange(k)/self.fs).ravel(); u.P = np.repeat(P, k, 0)
        self.t = u.ts[-1] + .1; self.runs.append(u)
    def dense(self, u, fn):
        """value of a dense per-run series at the samples"""
    def pose(self, dt):
        out = []; i = 0; dt = np.broadcast_to(np.asarray(dt, float), (sum(len(u.ts) for u in self.runs),))
        for u in self.runs:
            n = len(u.ts)
            if u.still: out.append(u.P)
            else:
                tt = u.ts + dt[i:i+n] - u.t0; g = np.arange(len(u.D))*DT
                out.append(np.c_[[np.interp(tt, g, u.D[:, k]) for k in range(3)]].T)
            i += n
        return np.concatenate(out)
    def ring(self, f0, zeta):
        """response of a bracket (unit static gain, 2nd order) to the acceleration, x and y and theta"""
        out = []; w = 2*np.pi*f0; tk = np.arange(0, 6/(zeta*w)+DT, DT)
        h = np.exp(-zeta*w*tk)*np.sin(w*np.sqrt(1-zeta**2)*tk); h /= h.sum()
        for u in self.runs:
            if u.still: out.append(np.zeros((len(u.ts), 3))); continue
            pad = 200; D = np.pad(u.D, ((pad, pad), (0, 0)), mode="edge")
            a = np.gradient(np.gradient(D, DT, axis=0), DT, axis=0)
            k = np.ones(8)/8
            a = np.c_[[np.convolve(np.convolve(a[:, j], k, "same"), h)[:len(a)] for j in range(3)]].T
            g = (np.arange(len(a))-pad)*DT
            out.append(np.c_[[np.interp(u.ts-u.t0, g, a[:, j]) for j in range(3)]].T)
        return np.concatenate(out)

# ------------------------------------------------------------------ the plant
class Case: pass
class S: pass
def rot(th, v):
    c, s = np.cos(th), np.sin(th); return np.c_[c*v[:, 0]-s*v[:, 1], s*v[:, 0]+c*v[:, 1]]
def hardware(r, form, diode, hot, lowamp):
    c = Case(); c.form, c.diode, c.hot = form, diode, hot
    c.fs = float(r.choice([250, 400, 500, 500, 625])); c.per_pose = int(r.integers(1, 4))
    c.span, c.lat = 9.7e-3, float(r.choice([5.2e-3, 6.0e-3, 7.3e-3, 8.1e-3]))
    c.span_t = c.span + r.uniform(-4e-6, 4e-6) + r.uniform(-.25e-6, .25e-6)*np.array([1, -1, 1, -1]); c.lat_t = c.lat + r.uniform(-8e-6, 8e-6)
    c.area = r.uniform(.03, .1, 2)
    c.amp0 = float(np.round(r.uniform(20000, 23000 if lowamp else 28000))); c.qn = float(np.round(r.uniform(10, 25), 1))
    c.amp = c.amp0*r.uniform(.92, 1.05, 4)
    c.imp = 1.0
    c.off = r.uniform(-.006, .006, (4, 2)); c.g = r.uniform(-.028, .028, 4); c.psi = np.deg2rad(r.uniform(-1.2, 1.2, 4))
    c.a3 = r.uniform(-.006, .006, (4, 2)); c.zero = r.uniform(-10e-6, 10e-6, 4)
    c.pnoise = lu(r, .08e-6, .25e-6)
    c.h = r.uniform(.055, .11); c.lx = r.uniform(.08, .1); c.ly = r.uniform(-8e-3, 8e-3)
    c.h_n, c.lx_n, c.ly_n = c.h*(1+r.uniform(-.03, .03)), c.lx+r.uniform(-1e-3, 1e-3), c.ly+r.uniform(-5e-4, 5e-4)
    c.h_n, c.lx_n, c.ly_n = (float(np.round(z, 4)) for z in (c.h_n, c.lx_n, c.ly_n))
    c.tfs = float(np.round(6e-3/c.h*r.uniform(1, 1.6), 3)); c.sum = float(np.round(r.uniform(22000, 34000), -2)); c.pn = float(np.round(r.uniform(1.2, 3.0), 1))
    c.dark = r.uniform(-8, 8, 4)*0
    c.o = c.area + r.uniform(-.02, .02, 2) - np.array([c.lx, c.ly])
    l = np.array([c.lx, c.ly])
    c.body2p = lambda th, k: c.o + rot(th, k + l)
    c.p2body = lambda P: rot(-P[:, 2], P[:, :2] - c.o) - l
    c.segs = [0] if form == "reference" else [0, 1, 2, 3]
    c.refz = r.uniform(-.01, .01)
    return c
def geom(c, P, i, span):
    ax = i % 2
    p = P[:, ax] + SG[i]*span[i]/2*P[:, 2]
    q = P[:, 1-ax] + LG[i]*c.lat_t*P[:, 2]
    return p, q
def measure(c, m, effs, noise=False):
    """effs: list of (function, parameters, strength). Noise-free analog values, or counts as logged."""
    N = m.N; s = S(); s.c, s.m = c, m
    s.dp = np.zeros((N, 4)); s.la = np.zeros((N, 4)); s.off = np.zeros((N, 4, 2)); s.psi = np.zeros((N, 4)); s.g = np.zeros((N, 4))
    s.dt = np.zeros((N, 4)); s.dtp = np.zeros(N); s.dc = np.zeros((N, 2)); s.do = np.zeros((N, 2)); s.dh = np.zeros(N)
    s.harm, s.post, s.psd, s.cur, s.logged, s.final = [], [], [], [], [], []
    s.span = c.span_t.copy(); s.scale = np.ones(4); s.nf = np.ones((N, 4)); s.pf = np.ones(N); s.h3 = np.ones((N, 4)); s.slip = np.zeros((N, 4), int)
    s.skew = (0, 0, 0); s.th = np.zeros(N); s.k3 = 0
    s.p = np.zeros((N, 4)); s.q = np.zeros((N, 4))
    for i in range(4): s.p[:, i], s.q[:, i] = geom(c, m.P0, i, s.span)
    s.v = np.c_[[m.V[:, i % 2] + SG[i]*c.span/2*m.V[:, 2] for i in range(4)]].T
    for f, prm, k in effs: f(s, prm, k)
    rn = np.random.default_rng([m.seed[0], m.seed[1], m.seed[2], 77]) if noise else None
    qs, qc, n, pm_ = (np.zeros((N, 4)) for _ in range(4)); sig = np.zeros((N, 4, 2)); s.tot = np.zeros((N, 4))
    for i in c.segs:
        P = m.pose(-s.dt[:, i]) if np.any(s.dt[:, i]) else m.P0
        p, q = geom(c, P, i, s.span)
        ex, ey, gam = s.skew
        p = p/(1 + (ey if i % 2 else ex)) + (gam*q if i % 2 == 0 else 0)
        p = p + s.dp[:, i] + c.zero[i]
        s.tot[:, i] = p
        ph = F*p; A = np.exp(s.la[:, i]); im = c.imp
        S3 = s.h3[:, i]
        a = A*(np.sin(ph + im*c.psi[i] + s.psi[:, i])*(1 + im*c.g[i]/2 + s.g[:, i]/2) + S3*im*c.a3[i, 0]*np.sin(3*ph))
        b = A*(np.cos(ph - s.psi[:, i])*(1 - im*c.g[i]/2 - s.g[:, i]/2) + S3*im*c.a3[i, 1]*np.cos(3*ph))
        for h in s.harm: da, db = h(i, ph); a = a + A*da; b = b + A*db
        a = a + im*c.off[i, 0] + s.off[:, i, 0]; b = b + im*c.off[i, 1] + s.off[:, i, 1]
        sig[:, i, 0], sig[:, i, 1] = a, b
    for f in s.post: f(sig)
    for i in c.segs: sig[:, i] *= c.amp[i]
    if noise and c.form != "positions": sig += rn.standard_normal(sig.shape)*(c.qn*s.nf)[:, :, None]
    for f in s.logged: f(sig)
    if noise and c.form != "positions":
        sig = np.round(sig) + 0.0; s.over = int((np.abs(sig) > 32767).sum()); sig = np.clip(sig, -32768, 32767)
    out = {}
    at = np.arctan2(sig[..., 0], sig[..., 1])/F
    n = np.round((s.tot - at)/RHO).astype(int)
    # the counter must give the tooth in which atan2 lies
    pbar = n*RHO + at + s.slip*RHO
    if c.form == "positions" and noise: pbar = pbar + rn.standard_normal((N, 4))*c.pnoise*s.nf
    for f in s.final: pbar = f(pbar)
    out.update(sig=sig, n=n + s.slip, p=pbar, seen=m.seen if c.diode else np.zeros(N, bool))
    if c.diode:
        P = m.pose(s.dtp) if np.any(s.dtp) else m.P0
        cc = rot(-P[:, 2], P[:, :2] - c.o - s.do) - np.array([c.lx, c.ly]) + s.dc
        u = cc/(c.h + s.dh)[:, None]/c.tfs
        for f in s.psd: u = f(u)
        tot = np.full(N, c.sum); e = np.c_[tot*(1+u[:, 0])/2, tot*(1-u[:, 0])/2, tot*(1+u[:, 1])/2, tot*(1-u[:, 1])/2]
        for f in s.cur: e = f(e)
        if noise: e = np.round(e + rn.standard_normal(e.shape)*c.pn*s.pf[:, None]); s.over = getattr(s, "over", 0) + int((np.abs(e[m.seen]) > 32767).sum())
        e[~m.seen] = 0
        out["e"] = e
        d = np.where(m.seen, e[:, 0]+e[:, 1], 1); d2 = np.where(m.seen, e[:, 2]+e[:, 3], 1)
        out["tan"] = c.tfs*np.c_[(e[:, 0]-e[:, 1])/d, (e[:, 2]-e[:, 3])/d2]
    if c.form == "reference":
        P = m.P0; ref = geom(c, P, 0, c.span_t)[0] + c.refz
        out["ref"] = ref + (rn.standard_normal(N)*5e-8 if noise else 0)
    out["over"] = getattr(s, "over", 0)
    return out

# ------------------------------------------------------------------ the baseline (equations 3, 5, 11)
def gam(p):
    return np.c_[np.ones(len(p)), *[g(o*F*p) for o in (1, 2, 4, 6) for g in (np.sin, np.cos)]]
def fit(c, o, rows=None):
    p = o["p"]
    if c.form == "reference":
        G = gam(p[:, 0]); y = o["ref"] - p[:, 0]; k = np.linalg.lstsq(G, y, rcond=None)[0]
        return {"segment_1": y - G@k}
    G = [gam(p[:, i]) for i in range(4)]; K = np.zeros((4, 9)); sg = np.array([1, -1, -1, 1.])
    seen = o["seen"]; B = seen.sum() > 0
    if not B:
        A = np.hstack([sg[i]*G[i][:, (0 if i == 0 else 1):] for i in range(4)]); y = -(p@sg)
        k = np.linalg.lstsq(A, y, rcond=None)[0]; return {"g_p": A@k - y}
    q = np.array([c.h_n, c.lx_n, c.ly_n, 0, 0]); T = o["tan"][seen]; ss = np.array([1, 1, -1, -1])/(2*c.span)
    w = 1/np.array([.24e-6, .6e-6, 1.2e-6])
    for it in range(5):
        ph = np.c_[[p[:, i] + G[i]@K[i] for i in range(4)]].T; gp = ph@sg
        th = (ph@ss)[seen]; C, Sn = np.cos(th), np.sin(th); h, lx, ly, ox, oy = q; cx, cy = h*T[:, 0], h*T[:, 1]
        gx = -(ph[seen, 0]+ph[seen, 2])/2 + C*(cx+lx) - Sn*(cy+ly) + ox
        gy = -(ph[seen, 1]+ph[seen, 3])/2 + Sn*(cx+lx) + C*(cy+ly) + oy
        if it == 0: q[3] -= gx.mean(); q[4] -= gy.mean(); gx -= gx.mean(); gy -= gy.mean()
        if it == 4: break
        dx, dy = -Sn*(cx+lx) - C*(cy+ly), C*(cx+lx) - Sn*(cy+ly)
        Jp = np.hstack([sg[i]*G[i] for i in range(4)]); Gs = [g[seen] for g in G]
        Jx = np.hstack([((-.5 if i % 2 == 0 else 0) + dx*ss[i])[:, None]*Gs[i] for i in range(4)])
        Jy = np.hstack([((-.5 if i % 2 == 1 else 0) + dy*ss[i])[:, None]*Gs[i] for i in range(4)])
        o1, z1 = np.ones(len(th)), np.zeros(len(th))
        Qx = np.c_[C*T[:, 0]-Sn*T[:, 1], C, -Sn, o1, z1]; Qy = np.c_[Sn*T[:, 0]+C*T[:, 1], Sn, C, z1, o1]
        J = np.vstack([np.hstack([Jp, np.zeros((len(gp), 5))])*w[0], np.hstack([Jx, Qx])*w[1], np.hstack([Jy, Qy])*w[2]])
        y = np.concatenate([gp*w[0], gx*w[1], gy*w[2]]); sc = np.linalg.norm(J, axis=0)+1e-30; Js = J/sc
        H = Js.T@Js; H[np.diag_indices_from(H)] += 1e-11
        st = np.linalg.solve(H, Js.T@y); r = y - Js@st; st += np.linalg.solve(H, Js.T@r)
        st /= sc; K -= st[:36].reshape(4, 9); q = q - st[36:]
    return {"g_p": gp, "g_x": gx, "g_y": gy}
def rms(res): return {k: float(np.sqrt(np.mean(v**2))) for k, v in res.items()}

# ------------------------------------------------------------------ catalogue effects: draw(r, c) -> prm ; act(s, prm, k)
def segpick(r, c, lo=1, hi=4):
    n = min(len(c.segs), int(r.integers(lo, hi+1))); return [int(i) for i in r.choice(c.segs, n, replace=False)]
def crng(s, tag): return np.random.default_rng([*s.m.seed, tag])
def d_lat(r, c): return dict(d=pm(r, .3, 1, 4)*(r.random(4) < .8) + 1e-3, m=r.uniform(.4, .9, 4), ph=r.uniform(0, 6.28, 4), nn=r.uniform(1.2, 3, 4), b2=r.uniform(0, .6, 4)*pm(r, 1, 1, 4), ph2=r.uniform(0, 6.28, 4))
def a_lat(s, d, k):   # edge row of teeth, displaced, comes and goes with the lateral phase: its weight in the flux centroid
    for i in range(4):
        z = F*s.q[:, i] + d["ph"][i]; w = 1 + d["m"][i]*np.cos(z) + .3*d["b2"][i]*np.cos(2*z+d["ph2"][i])
        s.dp[:, i] += k*5e-6*d["d"][i]*w/(d["nn"][i]+w)*3
def d_ext(r, c):
    o = {}
    for i in range(4):
        if r.random() < .75 or i == 0: o[i] = [(int(n), r.uniform(.2, 1), r.uniform(.2, 1), r.uniform(0, 6.28)) for n in r.choice([2, 4, 6, 7, 9], r.integers(1, 4), replace=False)]
    return o
def a_ext(s, d, k):   # even and high harmonics of the coils' flux (chamfered teeth, uneven coil halves)
    def h(i, ph):
        a = b = 0
        for n, u, v, z in d.get(i, []):
            q = 1 if n < 7 else .6
            a = a + k*.01*q*u*np.sin(n*ph+z); b = b + k*.01*q*v*np.cos(n*ph+z+(.7 if n % 2 == 0 else 3.1))
        return a, b
    s.harm.append(h)
def boxavg(D, a, b):
    Cc = np.cumsum(np.cumsum(np.pad(D, ((1, 0), (1, 0))), 0), 1)
    return (Cc[a:, b:] - Cc[:-a, b:] - Cc[a:, :-b] + Cc[:-a, :-b])/(a*b)
def d_tooth(r, c):
    n = 260; D = []
    for ax in range(2):
        G = r.standard_normal((n, n)); L = r.choice([0, 0, 1.5, 3.])
        if L:
            t = np.arange(-8, 9); w = np.exp(-t*t/(2*L*L)); G = np.apply_along_axis(lambda z: np.convolve(z, w, "same"), 0, G); G = np.apply_along_axis(lambda z: np.convolve(z, w, "same"), 1, G); G /= G.std()
        if r.random() < .4:                                        # dents: a few badly displaced teeth and their neighbours
            for _ in range(400):
                i, j = r.integers(2, n-3, 2); q = pm(r, 4, 12); G[i, j] += q; G[i+1, j] += .4*q; G[i, j+1] += .3*q
        a, b = int(r.integers(3, 7)), int(r.integers(3, 7))
        D.append(boxavg(G, a, b))
    return dict(D=D, w=1)
def field(D, X, Y):
    u, v = np.clip(X/RHO + 60, 0, D.shape[0]-2.001), np.clip(Y/RHO + 60, 0, D.shape[1]-2.001); i, j = u.astype(int), v.astype(int); u, v = u-i, v-j
    u, v = u*u*(3-2*u), v*v*(3-2*v)
    return D[i, j]*(1-u)*(1-v) + D[i+1, j]*u*(1-v) + D[i, j+1]*(1-u)*v + D[i+1, j+1]*u*v
def places(s, i):     # where on the platen segment i's centre is
    c = s.c; bx, by = [(-c.lat, -c.span/2), (c.span/2, -c.lat), (c.lat, c.span/2), (-c.span/2, c.lat)][i]
    return s.m.P0[:, 0] + bx - by*s.m.P0[:, 2], s.m.P0[:, 1] + by + bx*s.m.P0[:, 2]
def a_tooth(s, d, k):
    for i in range(4):
        X, Y = places(s, i); s.dp[:, i] += k*6e-6*field(d["D"][i % 2], X, Y)
def d_ang(r, c): return dict(d=pm(r, .2, 1, 4)*(r.random(4) < .8)+1e-3, o=pm(r, 0, 1, (4, 2))*r.choice([0, 1]), W=r.uniform(3e-3, 6e-3), z=r.uniform(-.006, .006, 4))
def a_ang(s, d, k):   # sine and cosine coils sit side by side: turning shifts their phases apart; the leakage offsets turn too
    th = s.m.P0[:, 2]
    for i in range(4):
        t = th + d["z"][i]
        s.psi[:, i] += k*.02*d["d"][i]*th/.01
        s.off[:, i] += k*.02*d["o"][i]*(th/.01)[:, None]*(1 + 12*t[:, None])
        s.h3[:, i] *= np.sinc(3*d["W"]*.3*t/RHO)/np.sinc(3*d["W"]*.3*d["z"][i]/RHO) if k else 1
def d_pnl(r, c): return dict(k3=pm(r, .5, 1), x=pm(r, .2, 1), k2=pm(r, 0, .5, 2), a=r.uniform(0, 1), o=r.uniform(-.15, .15, 2), m=int(r.integers(3)))
def a_pnl(s, d, k):   # tetralateral sheet: the fields of the two electrode pairs bend one another; off-centre; higher tail
    def f(u):
        v = u - d["o"]; r2 = v[:, :1]**2; cr = v[:, ::-1]**2
        e = d["k3"]*v*v**2*(1 + .3*r2) + d["x"]*v*cr*(d["m"] != 0) + d["k2"]*v[:, ::-1]*v*.6*(d["m"] != 1) + d["k2"][::-1]*v**2*.4*(d["m"] == 2)
        return u + k*.02*e
    s.psd.append(f)
def d_pmis(r, c): return dict(a=pm(r, .3, 1)*.01, g=pm(r, .5, 1), sh=pm(r, 0, 1)*r.choice([0, 1]))
def a_pmis(s, d, k):  # turned in its mount, tilted (one axis foreshortened), axes not quite square
    def f(u):
        a = k*d["a"]; v = np.c_[np.cos(a)*u[:, 0]+np.sin(a)*u[:, 1], -np.sin(a)*u[:, 0]+np.cos(a)*u[:, 1]]
        return np.c_[v[:, 0]*(1+k*.002*d["g"]) + k*.002*d["sh"]*v[:, 1], v[:, 1]*(1-k*.002*d["g"])]
    s.psd.append(f)
def d_th(r, c): return dict(c=pm(r, .2, 1, 4), al=pm(r, .3, 1)*22e-6*r.choice([0, 1, 1]), pd=pm(r, 0, 1, 2)*r.choice([0, 1]), tau=lu(r, 5, 60), g=r.uniform(-.002, .002, 4))
def a_th(s, d, k):    # housing grows behind the board's thermometer
    T = s.m.temp - s.m.temp[0]; t = s.m.ts; y = np.zeros(len(T)); 
    for j in range(1, len(T)): y[j] = y[j-1] + (1-np.exp(-(t[j]-t[j-1])/d["tau"]))*(T[j]-y[j-1])
    for i in range(4): s.dp[:, i] += k*(.4e-6*d["c"][i]*y + .5*d["al"]*y*(s.p[:, i]-s.c.area[i % 2])); s.g[:, i] += k*d["g"][i]*y*.3
    s.dc += k*.5e-6*d["pd"]*y[:, None]
def d_lag(r, c):
    t = r.uniform(0, 1, 4)*(r.random(4) < .85); t[r.integers(4) if len(c.segs) > 1 else 0] = 1.3
    return dict(t=t, m=int(r.integers(3)))
def a_lag(s, d, k):   # 0 pure delay, 1 first-order filter on the coil signals (phase and amplitude), 2 eddy currents with corner
    for i in range(4):
        tau = k*20e-6*d["t"][i]; w = F*s.v[:, i]
        if d["m"] == 0: s.dt[:, i] += tau
        elif d["m"] == 1: s.dp[:, i] -= np.arctan(w*tau)/F; s.la[:, i] -= .5*np.log1p((w*tau)**2)
        else: s.dp[:, i] -= s.v[:, i]*tau/(1+(w/2200)**2); s.la[:, i] -= .3*np.abs(w*tau)**1.5
def d_plat(r, c): return dict(t=pm(r, .5, 1))
def a_plat(s, d, k): s.dtp += k*200e-6*d["t"]
def d_hys(r, c): return dict(b=pm(r, .2, 1, 4) if r.random() < .6 else r.uniform(.1, 1, 4), w=lu(r, 3e-6, 60e-6), soft=r.uniform(.5, 1.5))
def a_hys(s, d, k):   # play: must travel w before the other branch is reached
    w = d["w"]; P = s.p[:, s.c.segs]; z = P[0].copy(); out = np.zeros_like(P)
    for j in range(len(P)):
        z = np.minimum(np.maximum(z, P[j]-w), P[j]+w); out[j] = P[j]-z
    for a, i in enumerate(s.c.segs): s.dp[:, i] += k*2e-6*d["b"][i]*np.tanh(d["soft"]*2*out[:, a]/w)/np.tanh(2*d["soft"])
def d_gap(r, c): return dict(n=3, kx=r.uniform(40, 260, 5), ky=r.uniform(40, 260, 5), ph=r.uniform(0, 6.28, 5), a=r.uniform(.3, 1, 5), tilt=r.uniform(-1, 1, 2), z=lu(r, 14e-6, 40e-6), o=pm(r, .3, 1, (4, 2)), kap=pm(r, .3, 1, 4)*r.choice([0, .5]), h=r.uniform(-1, 1, (4, 2)))
def a_gap(s, d, k):   # waviness and a wedge of the platen; flux falls as exp(-2 pi z/rho), the amplifiers' offsets do not
    im = min(k, 2.5); zs = max(1., k/2.5)
    for i in range(4):
        X, Y = places(s, i); X, Y = X-s.c.area[0], Y-s.c.area[1]; z = 0
        for a, kx, ky, ph in zip(d["a"], d["kx"], d["ky"], d["ph"]): z = z + a*np.sin(kx*X+ky*Y+ph)
        z = zs*d["z"]*(.6*z + d["tilt"][0]*X/.02 + d["tilt"][1]*Y/.02); z = np.clip(z, -25e-6, 170e-6)
        s.la[:, i] -= F*z; s.h3[:, i] *= np.exp(-2*F*z)
        s.off[:, i] += im*.02*d["o"][i]; s.dp[:, i] += im*.03*d["kap"][i]*z
def d_vib(r, c):
    n = int(r.integers(1, 4)); return dict(f=[lu(r, 7, min(150, .4*c.fs)) for _ in range(n)], a=r.uniform(.3, 1, n), dr=r.uniform(0, 6.28, n), am=r.uniform(0, .4))
def a_vib(s, d, k):
    r = crng(s, 5); t = s.m.ts
    for f, a, q in zip(d["f"], d["a"], d["dr"]):
        y = k*3e-6*a*(1 + d["am"]*np.sin(2*np.pi*.13*t + r.uniform(0, 6)))*np.sin(2*np.pi*f*t + r.uniform(0, 6.28)); s.do += np.c_[np.cos(q)*y, np.sin(q)*y]
def d_skew(r, c): z = r.uniform(0, 6.28); return dict(e=np.cos(z), g=np.sin(z))
def a_skew(s, d, k): s.skew = (k*3e-4*d["e"], -k*3e-4*d["e"], k*8e-4*d["g"])
def d_slip(r, c): return dict(i=int(r.choice(c.segs)), n=int(pm(r, 1, 1)*r.integers(1, 4)))
def a_slip(s, d, k):
    j = int(crng(s, 6).uniform(.2, .8)*s.m.N)
    if k: s.slip[j:, d["i"]] += d["n"]
def d_out(r, c): return dict(f=lu(r, .003, .03), lo=15., hi=lu(r, 40, 200), what=str(r.choice(["all", "one", "seg"] + (["psd"] if c.diode else []))), L=int(r.integers(1, 7)), i=int(r.choice(c.segs)))
def a_out(s, d, k):   # a contactor or a spark near the cable
    if not k: return
    r = crng(s, 7); N = s.m.N; hit = np.zeros((N, 4)); pool = np.flatnonzero(s.m.seen) if d["what"] == "psd" else np.arange(N)
    need = max(4, int(d["f"]*len(pool)))
    while (np.abs(hit).max(1) > 0).sum() < need:
        j = int(r.choice(pool)); L = int(r.integers(1, d["L"]+1))
        for q in range(j, min(N, j+L)):
            a = pm(r, 1, 1)*np.exp(r.uniform(np.log(d["lo"]), np.log(d["hi"])))
            if d["what"] in ("one", "seg"): hit[q, d["i"]] = a
            else: hit[q] = a*pm(r, .6, 1, 4)
    ch = r.standard_normal((N, 4, 2)); ch /= np.abs(ch).max(2, keepdims=True)
    if d["what"] == "psd": s.cur.append(lambda e: e + hit*s.c.pn)
    elif s.c.form == "positions": s.final.append(lambda p: p + hit*s.c.pnoise)
    else: s.logged.append(lambda g: np.copyto(g, np.clip(g + ch*hit[:, :, None]*s.c.qn, -32767, 32767)))
def d_exc(r, c): return dict(f=lu(r, 1.6, 6), what=str(r.choice(["all", "seg"] + (["psd"] if c.diode else []))), i=segpick(r, c, 1, 2))
def a_exc(s, d, k):
    if not k: return
    if d["what"] == "psd": s.pf *= d["f"]
    elif d["what"] == "all": s.nf *= d["f"]
    else: s.nf[:, d["i"]] *= max(d["f"], 2.5)
def d_clip(r, c):
    ch = [(i, int(r.integers(2))) for i in segpick(r, c, 1, 2)]
    if r.random() < .4: ch += [(i, 1-j) for i, j in ch]
    return dict(ch=ch, side=r.choice(["both", "both", "pos"]), w=lu(r, .002, .015), m=str(r.choice(["amp", "range"])))
def a_clip(s, d, k):
    L = 1 - .05*k
    L = max(L, .3)
    if d["m"] == "amp":
        def f(sig):
            for i, j in d["ch"]:
                x = sig[:, i, j]; a = np.abs(x); y = -d["w"]*np.logaddexp(-a/d["w"], -L/d["w"]); y = np.where(y < 0, a, y)
                sig[:, i, j] = np.where((x > 0) | (d["side"] == "both"), np.sign(x)*y, x)
        s.post.append(f)
    else:
        segs = {i for i, _ in d["ch"]}
        def f(sig):      # gain set too high for the converter: the peaks go over its range
            for i in segs:
                sig[:, i] *= 32767/(L*s.c.amp[i]); np.clip(sig[:, i], -32768, 32767, out=sig[:, i])
        if k: s.logged.append(f)
def d_qd(r, c): return dict(i=segpick(r, c, 1, 2), o=r.uniform(0, 1, (4, 2))*r.choice([0, 1]), g=r.uniform(0, 1, 4)*r.choice([0, 1]), ps=r.uniform(.3, 1, 4), m=int(r.integers(3)))
def a_qd(s, d, k):    # 0 wandering, 1 ageing towards a new value, 2 contact that changes now and then
    r = crng(s, 8); t = s.m.ts; T = t[-1]
    def course():
        y = raw(); return y/y.std()
    def raw():
        if d["m"] == 0:
            tk = np.linspace(0, T, 9); return np.interp(t, np.linspace(0, T, 65), np.interp(np.linspace(0, T, 65), tk, np.cumsum(r.standard_normal(9))))
        if d["m"] == 1: return pm(r, 1, 2)*(1-np.exp(-t/(T*r.uniform(.2, .7))))
        e = np.sort(r.choice(s.m.N, 5, replace=False)); return np.repeat(r.standard_normal(6)*1.3, np.diff(np.r_[0, e, s.m.N]))
    for i in d["i"]:
        s.off[:, i, 0] += k*.01*d["o"][i, 0]*course(); s.off[:, i, 1] += k*.01*d["o"][i, 1]*course()
        s.g[:, i] += k*.02*d["g"][i]*course(); s.psi[:, i] += k*.006*d["ps"][i]*course()
def d_span(r, c): z = pm(r, .4, 1, 2); z[1] = -z[0]*r.uniform(0, 1); return dict(z=z if r.random() < .5 else z[::-1])
def a_span(s, d, k): s.span = s.span + k*150e-6*np.array([d["z"][0], d["z"][1], d["z"][0], d["z"][1]])
CAT = {"lateral_dependence": (d_lat, a_lat, "bnp"), "extra_harmonics": (d_ext, a_ext, "bnpr"), "tooth_variation": (d_tooth, a_tooth, "bnpr"),
 "angle_dependence": (d_ang, a_ang, "bnp"), "psd_nonlinearity": (d_pnl, a_pnl, "bp"), "psd_misalignment": (d_pmis, a_pmis, "bp"),
 "thermal_drift": (d_th, a_th, "bnpr"), "velocity_lag": (d_lag, a_lag, "bnpr"), "psd_latency": (d_plat, a_plat, "bp"), "hysteresis": (d_hys, a_hys, "bnpr"),
 "gap_variation": (d_gap, a_gap, "bnr"), "beacon_vibration": (d_vib, a_vib, "bp"), "axis_skew": (d_skew, a_skew, "bp"), "cycle_slip": (d_slip, a_slip, "bnpr"),
 "outlier_bursts": (d_out, a_out, "bnpr"), "excess_noise": (d_exc, a_exc, "bnpr"), "adc_clipping": (d_clip, a_clip, "bnr"),
 "quadrature_drift": (d_qd, a_qd, "bnpr"), "span_error": (d_span, a_span, "bnp")}
NOSCALE = {"cycle_slip", "outlier_bursts", "excess_noise"}
DIODE = {"psd_nonlinearity", "psd_misalignment", "psd_latency", "beacon_vibration", "axis_skew"}

# ------------------------------------------------------------------ causes that are in no line of the catalogue
def one(r, c): return int(r.choice(c.segs))
def u_hum_d(r, c): return dict(f=float(r.choice([50, 60])), a=pm(r, .3, 1, (4, 2))*(np.arange(4) == one(r, c))[:, None], h3=r.uniform(0, .4))
def u_hum(s, d, k):
    r = crng(s, 11); t = s.m.ts; z = r.uniform(0, 6.28); w = np.sin(2*np.pi*d["f"]*t+z) + d["h3"]*np.sin(2*np.pi*3*d["f"]*t+2*z)
    s.off += k*.015*w[:, None, None]*d["a"]
def u_beat_d(r, c): return dict(f=lu(r, 3, 45), a=r.uniform(.2, 1, 4), dr=r.uniform(-.02, .02))
def u_beat(s, d, k):  # a neighbour courier's excitation, a little off in frequency, rectified with our own demodulator
    r = crng(s, 12); z = r.uniform(0, 6.28, 4); t = s.m.ts
    for i in range(4):
        w = 2*np.pi*d["f"]*(t + d["dr"]*np.sin(t/40)) + z[i]; s.off[:, i, 0] += k*.01*d["a"][i]*np.sin(w); s.off[:, i, 1] += k*.01*d["a"][i]*np.cos(w)
def u_brk_d(r, c): return dict(i=segpick(r, c, 1, 2), f=lu(r, 18, 70), z=r.uniform(.02, .12))
def u_brk(s, d, k):
    a = s.m.ring(d["f"], d["z"])
    for i in d["i"]: s.dp[:, i] -= k*3e-6*a[:, i % 2]
def u_cur_d(r, c): return dict(a=r.uniform(.2, 1, 4), z=r.uniform(0, 6.28, 4), fr=r.uniform(2, 8), q=r.uniform(.3, .9))
def u_cur(s, d, k):   # the motor's phase currents (they follow the tooth phase) leak into the coils in proportion to the thrust
    for i in range(4):
        th = s.m.A[:, i % 2] + d["fr"]*np.tanh(np.abs(s.m.V[:, i % 2])/.01)*np.abs(s.m.V[:, i % 2])/.05
        ph = F*s.p[:, i] + d["z"][i]; s.off[:, i, 0] += k*.004*d["a"][i]*th*np.cos(ph+1.2)*1; s.off[:, i, 1] += k*.004*d["a"][i]*th*np.sin(ph*1+d["q"])
def u_amb_d(r, c): return dict(u=pm(r, .5, 1, 2), n=int(r.integers(2, 5)))
def u_amb(s, d, k):   # daylight on the diode comes and goes with the clouds: the spot's centroid is drawn to the window's side
    r = crng(s, 13); b = s.m.ts[s.m.seen]; t = s.m.ts-b[0]; T = b[-1]-b[0]; fr = 0
    for _ in range(d["n"]): fr = fr + r.uniform(.3, 1)/(1+np.exp(-(t-T*r.uniform(.1, .9))/(.03*T)))*r.choice([-1, 1])
    fr = fr - fr.min(); fr = k*.002*fr/(2*fr[s.m.seen].std())
    def f(e):
        q = s.c.sum*fr[:, None]*np.array([1+d["u"][0], 1-d["u"][0], 1+d["u"][1], 1-d["u"][1]])/2; return e + q
    s.cur.append(f)
def u_dust_d(r, c): return dict(ax=int(r.integers(2)), n=int(r.integers(2, 4)), x=r.uniform(-.45, .45, 4), y=r.uniform(-.1, .1, 4), w=r.uniform(.03, .08, 4), a=pm(r, .5, 1, (4, 2)))
def u_dust(s, d, k):  # specks on the window shade one edge of the light spot
    def f(u):
        e = 0
        for j in range(d["n"]): e = e + d["a"][j]*np.exp(-((u[:, d["ax"]]-d["x"][j])/d["w"][j])**2/2)[:, None]
        return u + k*1e-3*e
    s.psd.append(f)
def u_jit_d(r, c): return dict(i=segpick(r, c, 1, 2))
def u_jit(s, d, k):
    r = crng(s, 14)
    for i in d["i"]: s.dt[:, i] += np.clip(k*60e-6*r.standard_normal(s.m.N), -.02, .02)
def u_clk_d(r, c): return dict(i=segpick(r, c, 1, 2), f=lu(r, 3, 22))
def u_clk(s, d, k):
    z = crng(s, 15).random()
    for i in d["i"]: s.dt[:, i] += k*100e-6*(((s.m.ts*d["f"]+z) % 1) - .5)
def u_kn_d(r, c): return dict(i=one(r, c), a=pm(r, 1, 1), cr=r.uniform(0, .5))
def u_kn(s, d, k):    # a loose segment shifts at a knock, and creeps a little after
    j = int(crng(s, 16).uniform(.25, .75)*s.m.N); t = s.m.ts-s.m.ts[j]
    s.dp[:, d["i"]] += k*4e-6*d["a"]*np.where(t >= 0, 1 + d["cr"]*(1-np.exp(-np.maximum(t, 0)/30)), 0)
def u_bc_d(r, c): return dict(q=r.uniform(0, 6.28), tau=r.uniform(.1, .5))
def u_bc(s, d, k):
    b = s.m.ts[s.m.seen]; z = np.clip((s.m.ts-b[0])/(b[-1]-b[0]), 0, 1); y = k*5e-6*(1-np.exp(-z/d["tau"])); s.do += np.c_[np.cos(d["q"])*y, np.sin(d["q"])*y]
def u_br_d(r, c): return dict(T=r.uniform(.08, .6))
def u_br(s, d, k):    # the overhead bridge rises and sinks (hall crane, air conditioning)
    r = crng(s, 17); b = s.m.ts[s.m.seen]; y = np.sin(2*np.pi*(s.m.ts-b[0])*r.uniform(.9, 1.1)/(d["T"]*(b[-1]-b[0]))+r.uniform(0, 6)) ; s.dh += k*2e-4*np.tanh(1.5*y)
def u_pit_d(r, c): return dict(f=lu(r, 14, 40), z=r.uniform(.06, .25), a=r.uniform(.6, 1.2, 2))
def u_pit(s, d, k):   # the air bearing lets the body pitch under acceleration: the diode's line of sight tilts
    a = s.m.ring(d["f"], d["z"]); s.dc += k*5e-6*a[:, :2]*d["a"]
def u_xt_d(r, c):
    i = one(r, c); j = int(r.choice([(i+1) % 4, (i+3) % 4])); return dict(i=i, j=j, a=pm(r, .4, 1), b=r.uniform(-1, 1))
def u_xt(s, d, k):    # the multiplexer has not settled from the other axis' channel
    def f(g): a = g[:, d["j"]].copy(); g[:, d["i"], 0] += k*.01*(d["a"]*a[:, 0]); g[:, d["i"], 1] += k*.01*(d["a"]*a[:, 1] + .5*d["b"]*a[:, 0])
    s.post.append(f)
def u_led_d(r, c): return dict(o=pm(r, .4, 1, 2), dr=r.uniform(.25, .5), m=int(r.integers(2)))
def u_led(s, d, k):   # the LED fades; amplifier offsets of the electrodes weigh more
    b = s.m.ts[s.m.seen]; z = np.clip((s.m.ts-b[0])/(b[-1]-b[0]), 0, 1); L = 1-d["dr"]*(z if d["m"] else 1-np.exp(-3*z))
    s.cur.append(lambda e: e*L[:, None] + k*40*np.array([d["o"][0], -d["o"][0], d["o"][1], -d["o"][1]]))
def u_rate_d(r, c): return dict(f=lu(r, 60, 150))
def u_rate(s, d, k):  # the diode's converter runs free and slower; firmware takes its mean delay off, not the age of each value
    T = k/d["f"]; s.dtp += np.clip(-T*(((s.m.ts + crng(s, 18).random())/max(T, 1e-9)) % 1 - .5), -.04, .04)
def u_hose_d(r, c): return dict(th=r.uniform(.002, .009), q=r.uniform(-.6, .6)+np.pi*r.integers(2), sg=pm(r, 1, 1))
def u_hose(s, d, k):  # a hose comes taut beyond an angle and bends the diode's bracket
    y = k*1e-3*np.maximum(0, d["sg"]*s.m.P0[:, 2]-d["th"]); s.dc += np.c_[np.cos(d["q"])*y, np.sin(d["q"])*y]
def u_fan_d(r, c): return dict(i=one(r, c), f=[lu(r, 15, .42*c.fs) for _ in range(int(r.integers(1, 3)))])
def u_fan(s, d, k):
    r = crng(s, 19)
    for f in d["f"]: s.dp[:, d["i"]] += k*2e-6*np.sin(2*np.pi*f*s.m.ts + r.uniform(0, 6.28))*r.uniform(.9, 1)
def u_cre_d(r, c): return dict(a=pm(r, .3, 1, 4), T=lu(r, .3, 4))
def u_cre(s, d, k):   # a plastic holder relaxes: it remembers where the cable pulled some seconds ago
    t = s.m.ts; z = s.p[0].copy(); o = np.zeros_like(s.p)
    for j in range(len(t)):
        if j: z = z + (1-np.exp(-(t[j]-t[j-1])/d["T"]))*(s.p[j]-z)
        o[j] = s.p[j]-z
    s.dp += k*4e-4*o*d["a"]
def u_mag_d(r, c): return dict(f=[(r.uniform(-.004, .016, 2), lu(r, 3e-3, 6e-3), pm(r, .4, 1, 2)) for _ in range(3)], g=r.uniform(.5, 1, (4, 2))*pm(r, 1, 1, (4, 2)))
def u_mag(s, d, k):   # clamps under the platen: a stray flux in both coils near them, no change of the gap
    for i in range(4):
        X, Y = places(s, i); X, Y = X-s.c.area[0], Y-s.c.area[1]
        if s.c.form == "reference": Y = np.zeros_like(X)
        for xy, w, a in d["f"]:
            q = 1/(1+((X-xy[0]*(1 if s.c.form != "reference" else 2.5))**2+(Y-(xy[1] if s.c.form != "reference" else 0))**2)/w**2)**1.5
            s.off[:, i] += k*.02*(a*d["g"][i])*q[:, None]
def u_mod_d(r, c): return dict(i=one(r, c), v=r.uniform(.013, .032), a=pm(r, 1, 1))
def u_mod(s, d, k):   # above a speed the firmware switches to its coarse interpolator, with another zero
    s.dp[:, d["i"]] += k*3e-6*d["a"]*(np.abs(s.v[:, d["i"]]) > d["v"])
OT, LT, TH, PL, DE, SP, DI, TI, FR, AM = "own tooth phase", "lateral tooth phase", "theta|angle", "place|platen", "deflection", "speed", "direction", "time", "frequency|vibration", "amplitude"
UNL = {"hum": (u_hum_d, u_hum, "bnr", [FR, TI, OT], "mains hum on one pair's signals (ground loop)"),
 "beat": (u_beat_d, u_beat, "bn", [FR, TI, OT], "beat with a neighbour courier's carrier on the coils"),
 "bracket": (u_brk_d, u_brk, "bnpr", [SP, TI, FR, DI], "loose bracket of a segment swings under acceleration"),
 "current": (u_cur_d, u_cur, "bnr", [OT, SP, TI, DI], "drive current leaks into the coils with thrust"),
 "daylight": (u_amb_d, u_amb, "b", [TI, DE, AM], "daylight on the diode changes with time"),
 "dust": (u_dust_d, u_dust, "bp", [DE], "dust specks on the diode window, narrow local bumps"),
 "jitter": (u_jit_d, u_jit, "bnpr", [SP], "trigger jitter of a segment: noise that grows with speed"),
 "clockbeat": (u_clk_d, u_clk, "bnpr", [SP, TI, FR], "sampling instant of a segment slides as a sawtooth (beating clocks), mean zero"),
 "knock": (u_kn_d, u_kn, "bnpr", [TI], "a loose segment shifts by some um at a knock"),
 "beaconcreep": (u_bc_d, u_bc, "bp", [TI], "the beacon's mount creeps to one side"),
 "bridge": (u_br_d, u_br, "bp", [TI, DE, FR], "overhead bridge rises and sinks: the height h changes with time"),
 "pitching": (u_pit_d, u_pit, "bp", [SP, TI, DE, FR, DI], "body pitches under acceleration, the diode's sight tilts"),
 "crosstalk": (u_xt_d, u_xt, "bn", [OT, LT], "multiplexer residue of the other axis' segment in a pair"),
 "ledfade": (u_led_d, u_led, "b", [TI, DE, AM], "LED fades over electrode amplifier offsets"),
 "psdrate": (u_rate_d, u_rate, "bp", [SP, TI, FR, DE], "diode converter runs free and slow: age of value is a sawtooth, mean compensated"),
 "hose": (u_hose_d, u_hose, "bp", [TH], "hose comes taut beyond an angle, bends the diode's bracket"),
 "fan": (u_fan_d, u_fan, "bnpr", [FR, TI], "a fan shakes one segment's holder"),
 "relax": (u_cre_d, u_cre, "bnpr", [TI, DI, SP, PL], "viscoelastic holder of the segments relaxes over seconds after a move"),
 "magnet": (u_mag_d, u_mag, "bnr", [PL, OT], "magnetic clamps under the platen add stray flux near them"),
 "modeswitch": (u_mod_d, u_mod, "bnpr", [SP], "firmware changes to another interpolator zero above a speed")}

# ------------------------------------------------------------------ plan of all three sets
FORM = {"b": "beacon", "n": "nobeacon", "p": "positions", "r": "reference"}
def plan():
    r = np.random.default_rng(90210); ones, twos, nones, unl = [], [], [], []
    names = list(CAT)
    for nm in names*3 + [str(z) for z in r.choice(names, 6, replace=False)]: ones.append(("one", [nm]))
    cnt = {n: 0 for n in names}; used = set()
    bad = [{"psd_misalignment", "axis_skew"}, {"excess_noise", "outlier_bursts"}]
    while len(twos) < 54:
        best = None
        for _ in range(60):
            a, b = (str(z) for z in r.choice(names, 2, replace=False)); k = frozenset((a, b))
            if k in used or k in map(frozenset, bad) or not set(CAT[a][2]) & set(CAT[b][2]): continue
            sc = cnt[a]+cnt[b]+r.random()
            if best is None or sc < best[0]: best = (sc, a, b, k)
        _, a, b, k = best; used.add(k); cnt[a] += 1; cnt[b] += 1; twos.append(("two", [a, b]))
    ul = list(UNL)*3; ul = ul[:42] if False else list(UNL)*2 + [str(z) for z in r.choice(list(UNL), 2, replace=False)]
    unl = [("unlisted", [u]) for u in ul]; nones = [("none", [])]*21
    sets = {1: [], 2: [], 3: []}
    for L in (ones, twos, nones, unl):
        L = list(L)
        if L[0][0] in ("two",): r.shuffle(L)
        if L[0][0] == "one": L = [L[(i % 19)+19*(i//19)] if i < 57 else L[i] for i in range(len(L))]; L = [L[19*k+j] for k in range(3) for j in range(19)] + L[57:]
        n = len(L)//3
        if L[0][0] == "one": parts = [L[0:19]+L[57:59], L[19:38]+L[59:61], L[38:57]+L[61:63]]
        elif L[0][0] == "unlisted": parts = [L[0:14], L[14:28], L[28:42]]
        else: parts = [L[k*n:(k+1)*n] for k in range(3)]
        for k in range(3): sets[k+1] += [tuple(z) for z in parts[k]]
    for k in sets:
        out = []; 
        for kind, nm in sets[k]:
            ok = "bnpr"
            for n in nm: ok = "".join(z for z in ok if z in (CAT[n] if n in CAT else UNL[n])[2])
            w = {"b": .5, "n": .22, "p": .2, "r": .24}; p = np.array([w[z] for z in ok]); out.append((kind, list(nm), str(r.choice(list(ok), p=p/p.sum()))))
        idx = r.permutation(len(out)); sets[k] = [out[i] for i in idx]
    return sets
PSDU = {"daylight", "dust", "beaconcreep", "bridge", "pitching", "ledfade", "psdrate", "hose"}

def write(d, c, m, o, stamp_id):
    os.makedirs(d, exist_ok=True)
    L = ["schema = 1", f'device = "courier {c.id}"', f'source = "recorder, log {stamp_id}"', "", "[geometry]", f"pitch_m = {RHO!r}", f"span_m = {c.span!r}", f"lateral_m = {c.lat!r}"]
    if c.diode: L += ["", "[coordination]", f"height_m = {c.h_n!r}", f"lever_x_m = {c.lx_n!r}", f"lever_y_m = {c.ly_n!r}", f"tan_full_scale = {c.tfs!r}"]
    L += ["", "[electronics]"]
    if c.form == "positions": L += [f"position_noise_m = {c.pnoise:.3e}"]
    else: L += ["adc_bits = 16", f"amplitude_counts = {c.amp0!r}", f"quadrature_noise_counts = {c.qn!r}"]
    if c.diode: L += [f"psd_sum_counts = {c.sum!r}", f"psd_noise_counts = {c.pn!r}"]
    open(d+"/recording.toml", "w").write("\n".join(L)+"\n")
    cols, fm, data = ["t_s", "run"], ["%.6f", "%s"], [m.stamp.tolist(), m.names.tolist()]
    def add(n, f, v): cols.append(n); fm.append(f); data.append(v.tolist())
    for i in c.segs:
        if c.form == "positions": add(f"p{i+1}_m", "%.9f", o["p"][:, i])
        else: add(f"q{i+1}s", "%d", o["sig"][:, i, 0]); add(f"q{i+1}c", "%d", o["sig"][:, i, 1]); add(f"n{i+1}", "%d", o["n"][:, i])
    if c.diode:
        for j, n in enumerate(("psd_xp", "psd_xn", "psd_yp", "psd_yn")): add(n, "%d", o["e"][:, j])
    add("temp_c", "%.4f", m.temp_read)
    add("cmd_x_m", "%.7f", m.cmd[:, 0])
    if c.form != "reference": add("cmd_y_m", "%.7f", m.cmd[:, 1]); add("cmd_theta_rad", "%.7f", m.cmd[:, 2])
    else: add("ref_x_m", "%.9f", o["ref"])
    fmt = ",".join(fm)
    with open(d+"/samples.csv", "w") as f:
        f.write(",".join(cols)+"\n"+"\n".join(fmt % z for z in zip(*data))+"\n")

def jsonable(x):
    if isinstance(x, dict): return {str(k): jsonable(v) for k, v in x.items() if k != "D"}
    if isinstance(x, (list, tuple)): return [jsonable(v) for v in x]
    if isinstance(x, np.ndarray): return x.tolist()
    if isinstance(x, np.generic): return x.item()
    return x
def build(K, idx, kind, names, fl, out, log):
    seed = [K, idx, 4711]; r = np.random.default_rng(seed); form = FORM[fl]
    needs = any(n in DIODE or n in PSDU for n in names)
    diode = form == "beacon" or (form == "positions" and (needs or r.random() < .5))
    hot = "thermal_drift" in names or r.random() < .25
    c = hardware(r, form, diode, hot, "gap_variation" in names or r.random() < .15); c.id = "%04d" % r.integers(10000)
    while True:
        m1, m2 = Motion(c, [K, idx, 1]), Motion(c, [K, idx, 2])
        if max(m1.N, m2.N) <= 14000: break
        c.fs = float(round(c.fs*.8))
    # imperfections that the baseline takes up: shrink until what is left of them is far below the noise
    for _ in range(8):
        b0 = rms(fit(c, measure(c, m1, []))); nz = rms(fit(c, measure(c, m1, [], True)))
        if all(b0[q] < .04*nz[q] for q in b0): break
        c.imp *= .8
    effs, info = [], []
    for n in names:
        dr, act = (CAT[n] if n in CAT else UNL[n])[:2]
        for tries in range(4):
            prm = dr(r, c)
            if kind == "two" and n == "excess_noise": prm["f"] = min(prm["f"], 3.)
            if n in NOSCALE:
                k = 1.0; tgt = None
                q0, q = nz, rms(fit(c, measure(c, m1, [(act, prm, 1.0)], True))); ch = max(q, key=lambda z: q[z]/q0[z]); got = float(np.sqrt(max(0, q[ch]**2-q0[ch]**2))); ok = True
                break
            tgt = lu(r, .7e-6, 4e-6); k = 1.0; lo = 0
            for it in range(12):
                q = rms(fit(c, measure(c, m1, [(act, prm, k)]))); got = max(q.values()); ch = max(q, key=q.get)
                if abs(got/tgt-1) < .03: break
                k *= float(np.clip(tgt/max(got, 1e-12), .25, 6))**(1 if it < 6 else .6)
            ok = abs(got/tgt-1) < .1
            if ok: break
        if not ok: log.append((idx, n, form, "not scaled", k, got, tgt))
        effs.append((act, prm, k)); info.append(dict(name=n, k=k, target_m=tgt, rms_m=got, channel=ch, prm=jsonable(prm)))
    o1, o2 = measure(c, m1, effs, True), measure(c, m2, effs, True)
    q2 = rms(fit(c, measure(c, m2, effs))) if not any(n in NOSCALE for n in names) else None
    r1, r2 = rms(fit(c, o1)), rms(fit(c, o2))
    for s, m, o in (("first", m1, o1), ("second", m2, o2)):
        assert np.all(np.diff(m.stamp) > 0), "time"
        if o["over"]: log.append((idx, names, "over range", o["over"]))
        write(f"{out}/c{idx:03d}/{s}", c, m, o, int(r.integers(100, 999)))
    return dict(case=f"c{idx:03d}", kind=kind, form=form, effects=names if kind in ("one", "two") else [], unlisted=UNL[names[0]][4] if kind == "unlisted" else None,
      places=UNL[names[0]][3] if kind == "unlisted" else [], params=dict(effects=info, diode=bool(diode), imp=c.imp, samples=[m1.N, m2.N], noise_rms_m=nz, first_rms_m=r1, second_rms_m=r2, second_clean_rms_m=q2),
      rms_m=max([i["rms_m"] for i in info], default=0.0))
def main():
    a = argparse.ArgumentParser(); a.add_argument("--set", type=int, required=True); a.add_argument("--out", required=True); a.add_argument("--only", type=int, default=-1); a = a.parse_args()
    P = plan()[a.set]; T = []; log = []
    for i, (k, n, f) in enumerate(P):
        if a.only >= 0 and i != a.only: continue
        T.append(build(a.set, i, k, n, f, a.out, log))
    json.dump(T, open(a.out+"/truth.json", "w"), indent=1)
    for z in log: print(*z, file=sys.stderr)
if __name__ == "__main__": main()
