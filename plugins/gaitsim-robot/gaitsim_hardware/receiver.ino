// Plays the servo pulses that `gaitsim drive` sends over USB, on servos at @BOARDS_TEXT@, and
// reports the tilt of an MPU6050 at 0x68. Written by gaitsim for @TITLE@.
//
// Before the first start: suspend the robot so that its feet touch nothing, set a low current
// limit on the power supply, and be ready to cut the power.
//
// Connect the power supply of the servos to the boards' V+ terminal, never through the Arduino,
// and connect all grounds. Set FORWARD, LEFT and UP below.
//
// The servos are switched off if no valid pulses arrive for TIMEOUT_MS, and at the end of the program.
//
// Library: Adafruit PWM Servo Driver (Library Manager).

#include <Wire.h>
#include <Adafruit_PWMServoDriver.h>
#include "servos.h"

const uint32_t BAUD = 115200;
const uint32_t TIMEOUT_MS = 200;
const int8_t VOLTAGE_PIN = -1;        // analog pin at a divider of the servos' voltage; -1 for none
const float MILLIVOLTS = 10;          // per digit of that pin
const uint32_t OSCILLATOR = 25000000; // Hz; differs by a few percent between boards: measure a pulse
const uint8_t FREQUENCY = 50;         // pulses per second

@SENSOR@
Adafruit_PWMServoDriver boards[BOARDS] = {
@BOARDS@
};

// A frame is A5 5A, number, length of the data, kind, data, and a CRC-32, the lowest byte first.
const uint8_t HEAD = 5, STATUS = 23, LONGEST = 2 * JOINTS;
const uint8_t OFF = 0, ON = 1, TRIPPED = 2;     // states
const uint8_t NO_SENSOR = 0, READY = 1, STILL_CALIBRATING = 2;
uint8_t state = OFF, sensor = NO_SENSOR;
uint8_t frame[HEAD + LONGEST + 4];
uint8_t filled = 0;
double tilt[3];                       // roll, pitch and yaw, rad
uint32_t sensed_us = 0, pulsed_ms = 0, heard_ms = 0;

uint32_t crc32(const uint8_t *bytes, uint8_t count) {
  uint32_t crc = 0xffffffff;
  while (count--) {
    crc ^= *bytes++;
    for (uint8_t bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc;
}

void drive(uint8_t joint, uint16_t tenths_us) {
  const float us = constrain(tenths_us / 10.0f, (float)LOWEST[joint], (float)HIGHEST[joint]);
  const uint16_t ticks = us * 4096.0f * FREQUENCY / 1000000.0f + 0.5f;
  boards[SERVO_BOARD[joint]].setPWM(SERVO_CHANNEL[joint], 0, tenths_us ? ticks : 4096);
}

void switch_off(uint8_t next) {
  state = next;
  for (uint8_t joint = 0; joint < JOINTS; joint++) drive(joint, 0);
}

uint8_t *put(uint8_t *place, int32_t value, uint8_t size) {
  while (size--) {
    *place++ = value & 255;
    value >>= 8;
  }
  return place;
}

void reply(uint8_t number) {
  uint8_t out[HEAD + STATUS + 4], *end = out;
  end = put(end, 0x5aa5, 2);
  end = put(end, number, 1);
  end = put(end, STATUS, 1);
  end = put(end, 's', 1);
  end = put(end, state, 1);
  end = put(end, JOINTS, 1);
  end = put(end, SERVOS, 4);
  end = put(end, VOLTAGE_PIN < 0 ? 0 : analogRead(VOLTAGE_PIN) * MILLIVOLTS, 2);
  end = put(end, lround(tilt[0] * 1e4), 2);
  end = put(end, lround(tilt[1] * 1e4), 2);
  end = put(end, lround(tilt[2] * 1e4), 4);
  for (uint8_t i = 0; i < 3; i++) end = put(end, lround(rates[i] * 1e3), 2);
  end = put(end, sensor, 1);
  end = put(end, crc32(out, end - out), 4);
  Serial.write(out, end - out);
}

void obey(uint8_t number, uint8_t kind, const uint8_t *data, uint8_t count) {
  if (kind == 'h') {  // hello: a program begins to drive the robot
    switch_off(OFF);
    start_calibration();
    tilt[2] = 0;
    if (sensor) sensor = STILL_CALIBRATING;
  } else if (kind == 'o') {
    switch_off(OFF);
  } else if (kind == 'p' && count == 2 * JOINTS && state != TRIPPED) {
    state = ON;
    pulsed_ms = millis();
    for (uint8_t joint = 0; joint < JOINTS; joint++) {
      drive(joint, data[2 * joint] | (uint16_t)data[2 * joint + 1] << 8);
    }
  }
  reply(number);
}

// Drops the first bytes of the frame, up to the next one that may begin a header.
void skip() {
  uint8_t first = 1;
  while (first < filled && frame[first] != 0xa5) first++;
  filled -= first;
  memmove(frame, frame + first, filled);
}

void receive(uint8_t value) {
  frame[filled++] = value;
  while (filled) {
    const bool wrong = frame[0] != 0xa5 || (filled > 1 && frame[1] != 0x5a) ||
                       (filled > 3 && frame[3] > LONGEST);
    const uint8_t whole = filled > 3 ? HEAD + frame[3] + 4 : 255;
    if (!wrong && filled < whole) return;
    if (!wrong) {
      const uint8_t *sum = frame + whole - 4;
      const uint32_t crc = (uint32_t)sum[3] << 24 | (uint32_t)sum[2] << 16 | (uint32_t)sum[1] << 8 | sum[0];
      if (crc == crc32(frame, whole - 4)) {
        obey(frame[2], frame[4], frame + HEAD, frame[3]);
        filled = 0;
        return;
      }
    }
    skip();
  }
}

void sense(float dt) {
  if (!read_sensor()) {
    sensor = NO_SENSOR;
    start_sensor();  // it may have lost its power
    return;
  }
  if (sensor == NO_SENSOR) {
    start_calibration();
    sensor = STILL_CALIBRATING;
  } else if (sensor == STILL_CALIBRATING) {
    if (!calibrated()) return;
    level_roll = level_pitch = 0;  // the robot may lie on its belly
    tilt[0] = roll_of(up);
    tilt[1] = pitch_of(up);
    sensor = READY;
  } else {
    integrate(dt, tilt);
  }
}

void setup() {
  Serial.begin(BAUD);
  Wire.begin();
  for (uint8_t board = 0; board < BOARDS; board++) {
    boards[board].begin();
    boards[board].setOscillatorFrequency(OSCILLATOR);
    boards[board].setPWMFreq(FREQUENCY);
  }
  Wire.setClock(400000);
  start_sensor();
  switch_off(OFF);
}

void loop() {
  while (Serial.available() > 0) {
    heard_ms = millis();
    receive(Serial.read());
  }
  if (millis() - heard_ms > 10) filled = 0;  // the rest of a frame was lost
  if (state == ON && millis() - pulsed_ms > TIMEOUT_MS) switch_off(TRIPPED);
  const uint32_t now = micros();
  if (now - sensed_us >= SENSE_US) {
    sense(fminf((now - sensed_us) * 1e-6f, 0.1f));
    sensed_us = now;
  }
}
