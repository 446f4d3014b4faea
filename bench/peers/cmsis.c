/* The interrupt's computation written with CMSIS-DSP's functions: phase, amplitude, harmonics, sums. */
#include <stdint.h>
#include "arm_math.h"

typedef struct {
    float offset[4][2];
    float k[4][9];
    float pitch_m, span_m, amplitude[2], full_scale;
} Coefficients;

typedef struct {
    float pose[5];
    float parity_m;
    float tan_psi[2];
    uint32_t status;
} Outcome;

static float error(const float *k, float phase)
{
    static const float order[4] = {1.0f, 2.0f, 4.0f, 6.0f};
    float functions[8], sum;
    for (int n = 0; n < 4; n++) {
        functions[2 * n] = arm_sin_f32(order[n] * phase);
        functions[2 * n + 1] = arm_cos_f32(order[n] * phase);
    }
    arm_dot_prod_f32(k + 1, functions, 8, &sum);
    return k[0] + sum;
}

void peer_step(const Coefficients *c, const int16_t (*quadrature)[2], const int16_t *electrodes, Outcome *out)
{
    float p[4];
    out->status = 0;
    for (int i = 0; i < 4; i++) {
        float sine = quadrature[i][0] - c->offset[i][0], cosine = quadrature[i][1] - c->offset[i][1];
        float amplitude, phase;
        arm_sqrt_f32(sine * sine + cosine * cosine, &amplitude);
        arm_atan2_f32(sine, cosine, &phase);
        out->status |= (uint32_t)(amplitude < c->amplitude[0] || amplitude > c->amplitude[1]) << i;
        p[i] = phase * (c->pitch_m / (2.0f * PI)) + error(c->k[i], phase);
    }
    float theta_x = (p[0] - p[2]) / c->span_m, theta_y = (p[1] - p[3]) / c->span_m;
    out->pose[0] = 0.5f * (p[0] + p[2]);
    out->pose[1] = 0.5f * (p[1] + p[3]);
    out->pose[2] = theta_x;
    out->pose[3] = theta_y;
    out->pose[4] = 0.5f * (theta_x + theta_y);
    out->parity_m = p[0] - p[1] - p[2] + p[3];
    for (int axis = 0; axis < 2; axis++) {
        float plus = electrodes[2 * axis], minus = electrodes[2 * axis + 1];
        out->tan_psi[axis] = plus + minus > 1000.0f ? c->full_scale * (plus - minus) / (plus + minus) : 0.0f;
    }
}
