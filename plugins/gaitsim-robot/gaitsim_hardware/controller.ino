// @TITLE@
//
// Follows commands, with the reflexes in gait.c, on servos at @BOARDS_TEXT@ and with an
// MPU6050 at 0x68. Written by gaitsim.
//
// Needs a board that computes 18 joints in 20 ms, such as an ESP32, a Teensy or an RP2040; an 8-bit
// AVR is too slow and has too little memory.
//
// Before the first start: suspend the robot so that its feet touch nothing, set a low current
// limit on the power supply, and be ready to cut the power. The first command is the standing
// pose, to which hobby servos turn at full speed from any position.
//
// Connect the power supply of the servos to the boards' V+ terminal, never through the Arduino,
// and connect all grounds. Set FORWARD, LEFT and UP below. Commands on the serial monitor at 115200
// baud, one in each line:
//   g        stand up on level ground and keep still for a second, which calibrates the sensor
//   w        walk at the gait's own speed
//   s 0.2    walk at this speed, m/s; negative is backward
//   t 30     turn at this speed to the left, degrees per second; negative is to the right
//   y 0.05   walk sideways to the left at this speed, m/s; negative is to the right
//   h 0.01   raise the trunk by this height, m; negative lowers it
//   0        stop softly and stand
//   x        switch off all servos at once: the robot sinks to the ground
// The robot stops softly if the sensor fails, and if no line arrives for TIMEOUT s; an empty line is
// enough. It switches off its servos if it is tilted by more than TIPPED rad.
//
// Library: Adafruit PWM Servo Driver (Library Manager).

#include <Wire.h>
#include <Adafruit_PWMServoDriver.h>
#include "gait.h"
#include "servos.h"

#if GAIT_NEEDS_CONTACTS || GAIT_NEEDS_LOAD
// Pins of the switches in the feet of @LEGS_TEXT@, which connect to ground.
const int8_t CONTACT_PINS[GAIT_LEGS] = {@PINS@};
#endif
const float TIMEOUT = 10;             // s; 0 for none
const float TIPPED = 1.0;             // rad
const uint32_t OSCILLATOR = 25000000; // Hz; differs by a few percent between boards: measure a pulse
const uint8_t FREQUENCY = 50;         // pulses per second
const uint32_t STEP_US = 20000;       // time between commands
const uint8_t RISE_STEPS = 3;         // steps between the first commands of two servos

@SENSOR@
Adafruit_PWMServoDriver boards[BOARDS] = {
@BOARDS@
};

const bool FEELS = GAIT_NEEDS_ORIENTATION || GAIT_NEEDS_RATES;  // otherwise, the sensor is optional
const uint8_t OFF = 0, RISING = 1, CALIBRATING = 2, CONTROLLED = 3;
uint8_t state = OFF;
uint8_t risen = 0;         // number of servos that have received their first command
uint8_t steps_waited = 0;  // steps since a servo last received its first command
gait_state gait;
gait_senses senses;
gait_command command;
double angles[GAIT_JOINTS];
bool sensed = false;               // whether the last measurement succeeded
uint32_t stepped_us = 0, sensed_us = 0, told_ms = 0;
char line[16];
uint8_t length = 0;

// Moves a servo; angles are in radians.
void drive(uint8_t joint, double angle) {
  if (!(fabs(angle) < 10)) return;  // not a number
  const float us = ZERO_US[joint] + US_PER_RADIAN[joint] * (float)angle;
  const float safe = constrain(us, (float)LOWEST[joint], (float)HIGHEST[joint]);
  const uint16_t ticks = safe * 4096.0f * FREQUENCY / 1000000.0f + 0.5f;
  boards[SERVO_BOARD[joint]].setPWM(SERVO_CHANNEL[joint], 0, ticks);
}

void stand() {
  command.speed = command.turn = command.sideways = command.height = 0;
}

void switch_off() {
  state = OFF;
  stand();
  for (uint8_t joint = 0; joint < GAIT_JOINTS; joint++) {
    boards[SERVO_BOARD[joint]].setPWM(SERVO_CHANNEL[joint], 0, 4096);
  }
}

void begin_gait() {
  gait_init(&gait);
  memset(&senses, 0, sizeof senses);
  told_ms = millis();
  stand();
  state = CONTROLLED;
  Serial.println(F("ready: w walks, 0 stops, x switches off"));
}

void orient(float dt) {
  integrate(dt, senses.orientation);
  for (uint8_t i = 0; i < 3; i++) senses.rates[i] = rates[i];
  if (fabs(senses.orientation[0]) > TIPPED || fabs(senses.orientation[1]) > TIPPED) {
    switch_off();
    Serial.println(F("tipped over: servos off"));
  }
}

void sense(float dt) {
  const bool before = sensed;
  sensed = read_sensor();
  if (!sensed) {
    start_sensor();  // it may have lost its power
    return;
  }
  if (state == CALIBRATING && calibrated()) begin_gait();
  if (state == CONTROLLED && before) orient(dt);
}

void read_feet() {
#if GAIT_NEEDS_CONTACTS || GAIT_NEEDS_LOAD
  uint8_t touching = 0;
  for (uint8_t leg = 0; leg < GAIT_LEGS; leg++) {
    senses.contacts[leg] = digitalRead(CONTACT_PINS[leg]) == LOW;
    touching += senses.contacts[leg] > 0;
  }
  // Switches do not measure loads: feet on the ground share the weight equally.
  for (uint8_t leg = 0; leg < GAIT_LEGS; leg++) {
    senses.load[leg] = touching ? senses.contacts[leg] / touching : 0;
  }
#endif
}

void start() {
#if GAIT_NEEDS_CONTACTS || GAIT_NEEDS_LOAD
  for (uint8_t leg = 0; leg < GAIT_LEGS; leg++) {
    if (CONTACT_PINS[leg] < 0) {
      Serial.println(F("set CONTACT_PINS in the sketch: the reflexes need contacts"));
      return;
    }
    pinMode(CONTACT_PINS[leg], INPUT_PULLUP);
  }
#endif
  if (state != OFF) return;
  risen = 0;
  steps_waited = RISE_STEPS;
  state = RISING;
}

// Moves the servos one by one, as all of them together would draw too much current.
void rise() {
  if (steps_waited++ < RISE_STEPS) return;
  steps_waited = 1;
  if (risen == GAIT_JOINTS) {
    start_calibration();
    state = CALIBRATING;
    if (!sensed) Serial.println(F("the sensor at 0x68 does not answer"));
    if (!sensed && !FEELS) begin_gait();
    return;
  }
  drive(risen, GAIT_STANDING[risen]);
  risen++;
}

void control(float dt) {
  if (TIMEOUT > 0 && millis() - told_ms > TIMEOUT * 1000) stand();
  read_feet();
  // Hobby servos do not report their angles: the last commands stand for them.
  for (uint8_t joint = 0; joint < GAIT_JOINTS; joint++) senses.joints[joint] = gait.angles[joint];
  gait_senses felt = senses;
  if (FEELS && !sensed) felt.orientation[0] = NAN;  // the gait stops after a moment
  gait_step(&gait, dt, &felt, &command, angles);
  for (uint8_t joint = 0; joint < GAIT_JOINTS; joint++) drive(joint, angles[joint]);
}

double limited(double value, double most) {
  return constrain(value, -most, most);
}

void obey() {
  told_ms = millis();
  const double value = atof(line + 1);
  switch (line[0]) {
    case 'g': start(); break;
    case 'w': stand(); command.speed = GAIT_SPEED; break;
    case 's': command.speed = limited(value, GAIT_MAX_SPEED); break;
    case 't': command.turn = limited(value * 3.14159265 / 180, GAIT_MAX_TURN); break;
    case 'y': command.sideways = limited(value, GAIT_MAX_SIDEWAYS); break;
    case 'h': command.height = limited(value, GAIT_MAX_HEIGHT); break;
    case '0': stand(); break;
  }
}

void read_commands() {
  while (Serial.available() > 0) {
    const char letter = Serial.read();
    if (letter == 'x') switch_off();  // without waiting for the end of the line
    if (letter != '\n' && letter != '\r') {
      if (length < sizeof line) line[length++] = letter;
      continue;
    }
    if (length < sizeof line) {  // longer lines are ignored
      line[length] = 0;
      obey();
    }
    length = 0;
  }
}

void setup() {
  Serial.begin(115200);
  Wire.begin();
  for (uint8_t board = 0; board < BOARDS; board++) {
    boards[board].begin();
    boards[board].setOscillatorFrequency(OSCILLATOR);
    boards[board].setPWMFreq(FREQUENCY);
  }
  Wire.setClock(400000);
  start_sensor();
  switch_off();
  Serial.println(F("g: stand up, w: walk, s 0.2: speed, t 30: turn, 0: stop, x: servos off"));
}

void loop() {
  read_commands();
  const uint32_t now = micros();
  if (now - sensed_us >= SENSE_US) {
    sense(fminf((now - sensed_us) * 1e-6f, 0.1f));
    sensed_us = now;
  }
  if (now - stepped_us >= STEP_US) {
    if (state == RISING) rise();
    if (state == CONTROLLED) control((now - stepped_us) * 1e-6f);
    stepped_us = now;  // a late step delays the gait; later steps do not catch up
  }
}
