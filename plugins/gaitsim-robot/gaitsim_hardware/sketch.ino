// @TITLE@
//
// Plays the gait in gait.h on servos at @BOARDS_TEXT@. Written by gaitsim.
//
// Before the first start: suspend the robot so that its feet touch nothing, set a low current
// limit on the power supply, and be ready to cut the power. The first command is the standing
// pose, to which hobby servos turn at full speed from any position.
//
// Connect the power supply of the servos to the boards' V+ terminal, never through the Arduino,
// and connect all grounds. Commands on the serial monitor at 115200 baud:
//   g  stand up, then start the gait    s  stop softly and stand
//   x  switch off all servos at once: the robot sinks to the ground
// A button between pin BUTTON and ground alternates between g and s.
//
// Library: Adafruit PWM Servo Driver (Library Manager).

#include <Wire.h>
#include <Adafruit_PWMServoDriver.h>
#include "gait.h"

const uint8_t BUTTON = 2;
const uint32_t OSCILLATOR = 25000000;  // Hz; differs by a few percent between boards: measure a pulse
const uint8_t FREQUENCY = 50;          // pulses per second
const uint8_t STEP_MS = 20;            // time between commands
const uint8_t RISE_STEPS = 3;          // steps between the first commands of two servos
const float RAMP_SECONDS = 1.5;        // shortest time from standing to the gait and back

Adafruit_PWMServoDriver boards[BOARDS] = {
@BOARDS@
};

const uint8_t OFF = 0, RISING = 1, STANDING_STILL = 2, STARTING = 3, PLAYING = 4, STOPPING = 5;
uint8_t state = OFF;
uint8_t risen = 0;         // number of servos that have received their first command
uint8_t steps_waited = 0;  // steps since a servo last received its first command
float now_us[JOINTS];      // current pulse of each servo
float from_us[JOINTS];     // pulse of each servo at the start of a ramp
float ramp_seconds = 0;
float ramp_done = 0;       // s
uint32_t played_us = 0;    // time since the start of the gait
uint32_t last_ms = 0;
bool was_pressed = false;

float frame_us(uint16_t keyframe, uint8_t joint) {
  return pgm_read_word(&GAIT[keyframe][joint]);
}

float standing_us(uint8_t joint) {
  return pgm_read_word(&STANDING[joint]);
}

void drive(uint8_t joint, float us) {
  us = constrain(us, (float)pgm_read_word(&LOWEST[joint]), (float)pgm_read_word(&HIGHEST[joint]));
  now_us[joint] = us;
  const uint16_t ticks = us * 4096.0f * FREQUENCY / 1000000.0f + 0.5f;
  boards[pgm_read_byte(&SERVO_BOARD[joint])].setPWM(pgm_read_byte(&SERVO_CHANNEL[joint]), 0, ticks);
}

void switch_off() {
  state = OFF;
  for (uint8_t joint = 0; joint < JOINTS; joint++) {
    boards[pgm_read_byte(&SERVO_BOARD[joint])].setPWM(pgm_read_byte(&SERVO_CHANNEL[joint]), 0, 4096);
  }
}

// Starts a ramp from the current pulses to the gait's first keyframe, or to standing.
void start_ramp(bool to_gait) {
  ramp_seconds = RAMP_SECONDS;
  ramp_done = 0;
  for (uint8_t joint = 0; joint < JOINTS; joint++) {
    const float target = to_gait ? frame_us(0, joint) : standing_us(joint);
    from_us[joint] = now_us[joint];
    ramp_seconds = fmaxf(ramp_seconds, fabsf(target - now_us[joint]) / pgm_read_word(&RAMP[joint]));
  }
  state = to_gait ? STARTING : STOPPING;
}

void start() {
  if (state == OFF) {
    risen = 0;
    steps_waited = RISE_STEPS;
    state = RISING;
  } else if (state == STANDING_STILL) {
    start_ramp(true);
  }
}

void stop_softly() {
  if (state == STARTING || state == PLAYING) {
    start_ramp(false);
  } else if (state == RISING) {
    switch_off();
  }
}

void read_commands() {
  while (Serial.available() > 0) {
    const char command = Serial.read();
    if (command == 'g') start();
    if (command == 's') stop_softly();
    if (command == 'x') switch_off();
  }
  const bool pressed = digitalRead(BUTTON) == LOW;
  if (pressed && !was_pressed) {
    if (state == OFF || state == STANDING_STILL) {
      start();
    } else {
      stop_softly();
    }
  }
  was_pressed = pressed;
}

// Moves the servos one by one, as all of them together would draw too much current.
void rise() {
  if (steps_waited++ < RISE_STEPS) return;
  steps_waited = 1;
  if (risen == JOINTS) {
    start_ramp(true);
    return;
  }
  drive(risen, standing_us(risen));
  risen++;
}

void ramp(bool to_gait) {
  ramp_done += STEP_MS / 1000.0f;
  const float x = fminf(ramp_done / ramp_seconds, 1.0f);
  const float share = x * x * (3 - 2 * x);  // smooth start and end
  for (uint8_t joint = 0; joint < JOINTS; joint++) {
    const float target = to_gait ? frame_us(0, joint) : standing_us(joint);
    drive(joint, from_us[joint] + share * (target - from_us[joint]));
  }
  if (x < 1) return;
  played_us = 0;
  state = to_gait ? PLAYING : STANDING_STILL;
}

void play() {
  played_us += STEP_MS * 1000UL;
  uint32_t keyframe = played_us / KEYFRAME_US;
  if (LOOP_FROM < KEYFRAMES) {
    while (keyframe >= KEYFRAMES) {
      played_us -= (KEYFRAMES - LOOP_FROM) * KEYFRAME_US;
      keyframe = played_us / KEYFRAME_US;
    }
  } else if (keyframe >= KEYFRAMES - 1UL) {  // played once
    for (uint8_t joint = 0; joint < JOINTS; joint++) drive(joint, frame_us(KEYFRAMES - 1, joint));
    start_ramp(false);
    return;
  }
  const uint16_t next = keyframe + 1 < KEYFRAMES ? keyframe + 1 : LOOP_FROM;
  const float share = (played_us - keyframe * KEYFRAME_US) / (float)KEYFRAME_US;
  for (uint8_t joint = 0; joint < JOINTS; joint++) {
    const float us = frame_us(keyframe, joint);
    drive(joint, us + share * (frame_us(next, joint) - us));
  }
}

void setup() {
  Serial.begin(115200);
  pinMode(BUTTON, INPUT_PULLUP);
  for (uint8_t board = 0; board < BOARDS; board++) {
    boards[board].begin();
    boards[board].setOscillatorFrequency(OSCILLATOR);
    boards[board].setPWMFreq(FREQUENCY);
  }
  Wire.setClock(400000);  // at 100 kHz, commands for more than 30 servos take longer than a step
  switch_off();
  Serial.println(F("g: stand and walk, s: stop softly, x: servos off"));
}

void loop() {
  read_commands();
  const uint32_t time_ms = millis();
  if (time_ms - last_ms < STEP_MS) return;
  last_ms = time_ms;  // a late step delays the gait; later steps do not catch up
  if (state == RISING) rise();
  else if (state == STARTING) ramp(true);
  else if (state == PLAYING) play();
  else if (state == STOPPING) ramp(false);
}
