// @TITLE@
//
// Written by gaitsim. C99, without dependencies. The algorithm is that of gaitsim's simulation:
// reflexes change the inputs of a rhythm, which moves the feet along their paths, and damped
// inverse kinematics turns the places of the feet into joint angles.

#include "gait.h"

#include <math.h>

#define SAMPLES @SAMPLES@     // of a foot's path in a cycle
#define MOST @MOST@         // joints of a leg, at most
#define SMOOTHING 0.2  // s, time constant of commands
#define HOLD 0.2       // s, how long the last valid measurement replaces invalid ones
#define RAMP_TIME 0.5  // s, from standing to the full gait and back
#define RESTORING 4.0  // 1/s, how quickly a leg's phase returns to that of the gait
#define ITERATIONS 2   // of the inverse kinematics
#define FARTHEST ((gait_real)0.5)  // rad, largest change of an angle in an iteration
#define LONGEST_STEP 0.1           // s

@TABLES@

static double gait_clip(double value, double low, double high) {
    return value < low ? low : value > high ? high : value;
}

static gait_real clip(gait_real value, gait_real low, gait_real high) {
    return value < low ? low : value > high ? high : value;
}

// For boards that compute only floats quickly. The compiler decides which function is called.
#define IS_FLOAT (sizeof(gait_real) == sizeof(float))
static gait_real sine(gait_real x) {
    return IS_FLOAT ? (gait_real)sinf((float)x) : (gait_real)sin((double)x);
}
static gait_real cosine(gait_real x) {
    return IS_FLOAT ? (gait_real)cosf((float)x) : (gait_real)cos((double)x);
}
static gait_real root(gait_real x) {
    return IS_FLOAT ? (gait_real)sqrtf((float)x) : (gait_real)sqrt((double)x);
}

@REFLEXES@
// The place of a leg's foot, its rotation, and the place and direction of the axes.
typedef struct {
    gait_real foot[3], rotation[3][3], anchor[MOST][3], axis[MOST][3];
} pose;

static void place(int leg, const gait_real angles[], pose *at) {
    const int low = FIRST[leg], joints = FIRST[leg + 1] - low;
    for (int i = 0; i < 3; i++) {
        at->foot[i] = 0;
        for (int k = 0; k < 3; k++) at->rotation[i][k] = i == k ? 1 : 0;
    }
    for (int j = 0; j < joints; j++) {
        const gait_real turned = angles[low + j] - (gait_real)GAIT_STANDING[low + j];
        const gait_real s = sine(turned), c = cosine(turned);
        const gait_real x = AXES[low + j][0], y = AXES[low + j][1], z = AXES[low + j][2];
        const gait_real *p = ANCHORS[low + j];
        for (int i = 0; i < 3; i++) {
            gait_real *row = at->rotation[i];
            const gait_real a = row[0], b = row[1], d = row[2];
            gait_real along = a * x + b * y + d * z;
            at->anchor[j][i] = at->foot[i] + (a * p[0] + b * p[1] + d * p[2]);
            at->axis[j][i] = along;
            along *= 1 - c;
            // Rodrigues' formula for a row, which turns backward.
            row[0] = a * c - (y * d - z * b) * s + x * along;
            row[1] = b * c - (z * a - x * d) * s + y * along;
            row[2] = d * c - (x * b - y * a) * s + z * along;
            at->foot[i] = at->anchor[j][i] - (row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
        }
    }
    for (int i = 0; i < 3; i++) {
        const gait_real *row = at->rotation[i];
        at->foot[i] += row[0] * TIPS[leg][0] + row[1] * TIPS[leg][1] + row[2] * TIPS[leg][2];
    }
}

// Solves (S S^T + damping) x = step in place by Cholesky's method; S is `slope`.
static void solve(int joints, gait_real slope[MOST][6], gait_real damping, gait_real step[MOST]) {
    gait_real normal[MOST][MOST];
    for (int i = 0; i < joints; i++) {
        for (int j = 0; j <= i; j++) {
            gait_real total = i == j ? damping : 0;
            for (int k = 0; k < 6; k++) total += slope[i][k] * slope[j][k];
            for (int k = 0; k < j; k++) total -= normal[i][k] * normal[j][k];
            normal[i][j] = i == j ? root(total) : total / normal[j][j];
        }
    }
    for (int i = 0; i < joints; i++) {
        gait_real total = step[i];
        for (int k = 0; k < i; k++) total -= normal[i][k] * step[k];
        step[i] = total / normal[i][i];
    }
    for (int i = joints - 1; i >= 0; i--) {
        gait_real total = step[i];
        for (int k = i + 1; k < joints; k++) total -= normal[k][i] * step[k];
        step[i] = total / normal[i][i];
    }
}

// Moves a leg's angles so that its foot follows its target, within limits of angle and speed.
static void follow(int leg, const gait_real target[3], gait_real dt, gait_real angles[]) {
    const int low = FIRST[leg], joints = FIRST[leg + 1] - low;
    const gait_real *weights = WEIGHTS[leg];
    gait_real before[MOST], error[6], slope[MOST][6], step[MOST];
    pose at;
    for (int j = 0; j < joints; j++) before[j] = angles[low + j];
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        place(leg, angles, &at);
        // Errors of the position, and of the rotation to first order.
        for (int k = 0; k < 3; k++) error[k] = weights[k] * (target[k] - at.foot[k]);
        error[3] = weights[3] * (at.rotation[1][2] - at.rotation[2][1]) / 2;
        error[4] = weights[4] * (at.rotation[2][0] - at.rotation[0][2]) / 2;
        error[5] = weights[5] * (at.rotation[0][1] - at.rotation[1][0]) / 2;
        gait_real damping = DAMPING;
        for (int k = 0; k < 6; k++) damping += error[k] * error[k] / 2;
        for (int j = 0; j < joints; j++) {
            const gait_real *axis = at.axis[j];
            const gait_real x = at.foot[0] - at.anchor[j][0];
            const gait_real y = at.foot[1] - at.anchor[j][1];
            const gait_real z = at.foot[2] - at.anchor[j][2];
            slope[j][0] = weights[0] * (axis[1] * z - axis[2] * y);
            slope[j][1] = weights[1] * (axis[2] * x - axis[0] * z);
            slope[j][2] = weights[2] * (axis[0] * y - axis[1] * x);
            for (int k = 0; k < 3; k++) slope[j][3 + k] = weights[3 + k] * axis[k];
            gait_real downhill = 0;
            for (int k = 0; k < 6; k++) downhill += slope[j][k] * error[k];
            const gait_real angle = angles[low + j];
            if ((angle <= LOWER[low + j] && downhill < 0) ||
                (angle >= UPPER[low + j] && downhill > 0)) {
                downhill = 0;
                for (int k = 0; k < 6; k++) slope[j][k] = 0;
            }
            step[j] = downhill;
        }
        solve(joints, slope, damping, step);
        for (int j = 0; j < joints; j++) {
            const gait_real angle = angles[low + j] + clip(step[j], -FARTHEST, FARTHEST);
            angles[low + j] = clip(angle, LOWER[low + j], UPPER[low + j]);
        }
    }
    for (int j = 0; j < joints; j++) {
        const gait_real most = SPEED_LIMIT[low + j] * dt;
        angles[low + j] = clip(angles[low + j], before[j] - most, before[j] + most);
    }
}

// Advances the rhythm with its inputs.
static void advance(gait_state *state, int walking, double dt) {
    const gait_inputs *inputs = &state->inputs;
    const double cycle = FREQUENCY * dt, small = dt / RAMP_TIME;
    state->activity += gait_clip((walking ? 1 : 0) - state->activity, -small, small);
    const double active = state->activity;
    if (active > 0) {
        state->clock += cycle;
        state->clock -= floor(state->clock);
    } else {
        state->clock = 0;
    }
    for (int leg = 0; leg < GAIT_LEGS; leg++) {
        if (active > 0) {
            const double drift =
                cycle * (inputs->rate[leg] - 1) - RESTORING * dt * state->lead[leg];
            state->lead[leg] += gait_clip(drift, -cycle, 0.25);
        } else {
            state->lead[leg] = 0;
        }
    }
    // Strokes that the command asks for; feet move against the trunk's motion.
    const double duration = DUTY / FREQUENCY;
    const double forward = inputs->command[0] / OWN_SPEED;
    const double turn = inputs->command[1] / GAINS[1] * duration;
    const double aside = inputs->command[2] / GAINS[2] * duration;
    double strokes[GAIT_LEGS][2], farthest = 0;
    for (int leg = 0; leg < GAIT_LEGS; leg++) {
        const double own = forward * inputs->stride[leg];
        const double x = own * STROKE[leg][0] - turn * FEET[leg][1];
        const double y = own * STROKE[leg][1] + turn * FEET[leg][0] + aside;
        const double far = sqrt(x * x + y * y);
        strokes[leg][0] = x;
        strokes[leg][1] = y;
        if (far > farthest) farthest = far;
    }
    state->scale = farthest > LONGEST ? LONGEST / farthest : 1;
    for (int leg = 0; leg < GAIT_LEGS; leg++) {
        const double phase = state->clock + state->lead[leg] + OFFSET[leg];
        const double where = (phase - floor(phase)) * SAMPLES;
        const int sample = where < SAMPLES ? (int)where : SAMPLES - 1;
        const gait_real t = (gait_real)(where - sample);
        gait_real on_path[3], target[3];
        for (int k = 0; k < 3; k++) {  // periodic cubics
            const gait_real a = (gait_real)PATH[leg][(sample + SAMPLES - 1) % SAMPLES][k];
            const gait_real b = (gait_real)PATH[leg][sample][k];
            const gait_real c = (gait_real)PATH[leg][(sample + 1) % SAMPLES][k];
            const gait_real d = (gait_real)PATH[leg][(sample + 2) % SAMPLES][k];
            on_path[k] =
                b + t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))) / 2;
        }
        const double ahead = (double)on_path[0] * state->scale;
        const double x = CENTRE[leg][0] + ahead * strokes[leg][0];
        const double y = CENTRE[leg][1] + (double)on_path[1] + ahead * strokes[leg][1];
        const double z = CENTRE[leg][2] + (double)on_path[2];
        const double lower = inputs->command[3] + inputs->reach[leg];
        target[0] = (gait_real)(active * x) + TIPS[leg][0];
        target[1] = (gait_real)(active * y) + TIPS[leg][1];
        target[2] = (gait_real)(active * z - lower) + TIPS[leg][2];
        follow(leg, target, (gait_real)dt, state->angles);
    }
}

static int all_finite(const double values[], int count) {
    for (int i = 0; i < count; i++) {
        if (!isfinite(values[i])) return 0;
    }
    return 1;
}

static int all_valid(const gait_senses *senses) {
    return all_finite(senses->orientation, 3) && all_finite(senses->rates, 3) &&
           all_finite(senses->contacts, GAIT_LEGS) && all_finite(senses->load, GAIT_LEGS) &&
           all_finite(senses->joints, GAIT_JOINTS);
}

void gait_init(gait_state *state) {
    static const gait_state start;  // zeros
    *state = start;
    state->scale = 1;
    for (int joint = 0; joint < GAIT_JOINTS; joint++) {
        state->angles[joint] = (gait_real)GAIT_STANDING[joint];
    }
@STARTS@}

void gait_step(gait_state *state, double dt, const gait_senses *senses, const gait_command *command,
               double angles[GAIT_JOINTS]) {
    dt = dt > 0 ? gait_clip(dt, 0, LONGEST_STEP) : 0;
    if (all_valid(senses)) {
        state->last = *senses;
        state->invalid = 0;
    } else {
        state->invalid += dt;
    }
    double target[4] = {command->speed, command->turn, command->sideways, command->height};
    if (state->invalid > HOLD || !all_finite(target, 4)) {
        for (int part = 0; part < 4; part++) target[part] = 0;
    }
    const double share = dt < SMOOTHING ? dt / SMOOTHING : 1;
    const int walking = target[0] != 0 || target[1] != 0 || target[2] != 0;
    for (int part = 0; part < 4; part++) {
        state->command[part] += share * (target[part] - state->command[part]);
        if (part < 3 && !walking && !(state->activity > 0)) state->command[part] = 0;
    }
    gait_seen seen;
    gait_inputs *inputs = &state->inputs;
    seen.orientation = state->last.orientation;
    seen.rates = state->last.rates;
    seen.contacts = state->last.contacts;
    seen.load = state->last.load;
    seen.joints = state->last.joints;
    seen.heading = state->heading;
    seen.duty = DUTY;
    for (int part = 0; part < 4; part++) {
        inputs->command[part] = seen.command[part] = state->command[part];
    }
    for (int leg = 0; leg < GAIT_LEGS; leg++) {
        const double phase = state->clock + state->lead[leg] + OFFSET[leg];
        seen.phase[leg] = phase - floor(phase);
        inputs->stride[leg] = inputs->rate[leg] = 1;
        inputs->reach[leg] = 0;
    }
@STEPS@    advance(state, walking, dt);
    state->heading += state->command[1] * state->scale * state->activity * dt;
    for (int joint = 0; joint < GAIT_JOINTS; joint++) angles[joint] = (double)state->angles[joint];
}
