// @TITLE@
//
// A gait with its reflexes, which follows commands. Written by gaitsim; see gait.c.
//
// Legs: @LEGS_TEXT@
// It needs: @NEEDS_TEXT@
//
//   gait_state state;
//   gait_senses senses = {{0}, {0}, {0}, {0}, {0}};
//   gait_command command = {GAIT_SPEED, 0, 0, 0};
//   double angles[GAIT_JOINTS];
//   gait_init(&state);
//   // 50 times per second:
//   senses.orientation[2] = yaw;
//   gait_step(&state, 0.02, &senses, &command, angles);
//
// The robot stands at first, with the angles of GAIT_STANDING. It also stands with a command of 0,
// and when measurements have been invalid, such as NaN, for 0.2 s; for as long, the last valid ones
// are used. Commands beyond the limits below are followed with shortened strokes.

#ifndef GAIT_H
#define GAIT_H

#define GAIT_LEGS @LEGS@
#define GAIT_JOINTS @JOINTS@

// Largest commands, one at a time, and the gait's own speed; SI units.
#define GAIT_MAX_SPEED @MAX_SPEED@
#define GAIT_MAX_TURN @MAX_TURN@
#define GAIT_MAX_SIDEWAYS @MAX_SIDEWAYS@
#define GAIT_MAX_HEIGHT @MAX_HEIGHT@
#define GAIT_SPEED @SPEED@

#define GAIT_INTERVAL @INTERVAL@  // s, duration of a step with which the gait evolved

// 1 for the measurements that the reflexes need; others may remain 0.
@NEEDS@

// Type of the numbers in inverse kinematics. Most boards compute float much faster. Angles differ
// by about 1e-6 rad, and for moments by more where a command moves a joint to its limit.
#ifndef GAIT_REAL
#ifdef ARDUINO
#define GAIT_REAL float
#else
#define GAIT_REAL double
#endif
#endif
typedef GAIT_REAL gait_real;

typedef struct {
    double orientation[3];       // rad, roll to the right, pitch nose down, yaw to the left
    double rates[3];             // rad/s, about the trunk's axes: forward, to the left, upward
    double contacts[GAIT_LEGS];  // 1 for a foot on the ground, or 0
    double load[GAIT_LEGS];      // vertical force on each foot as a share of the weight
    double joints[GAIT_JOINTS];  // rad, angles reported by the servos
} gait_senses;

typedef struct {
    double speed;     // m/s forward
    double turn;      // rad/s to the left
    double sideways;  // m/s to the left
    double height;    // m upward
} gait_command;

typedef struct {
    const double *orientation, *rates, *contacts, *load, *joints;
    double command[4];
    double heading;
    double phase[GAIT_LEGS];
    double duty;
} gait_seen;

typedef struct {
    double command[4], stride[GAIT_LEGS], reach[GAIT_LEGS], rate[GAIT_LEGS];
} gait_inputs;

@STATES@

typedef struct {
    double command[4];  // smoothed
    double heading;     // rad to the left, the direction that commands asked for
    double clock;       // cycles
    double lead[GAIT_LEGS];
    double activity;    // 0 when standing to 1 in the full gait
    double scale;       // factor of strokes that were too long, or 1
    double invalid;     // s, since the last valid measurement
    gait_senses last;   // last valid measurement
    gait_inputs inputs;
    gait_real angles[GAIT_JOINTS];
@STATE_FIELDS@
} gait_state;

#ifdef __cplusplus
extern "C" {
#endif

extern const char *const GAIT_JOINT_NAMES[GAIT_JOINTS];
extern const double GAIT_STANDING[GAIT_JOINTS];  // rad

// Stands at once, with a heading of 0.
void gait_init(gait_state *state);

// Advances the gait by `dt` s, at most 0.1 s, and sets the angles of the joints, rad.
void gait_step(gait_state *state, double dt, const gait_senses *senses, const gait_command *command,
               double angles[GAIT_JOINTS]);

#ifdef __cplusplus
}
#endif

#endif
