// The sensor, an MPU6050.
const int8_t FORWARD = 1, LEFT = 2, UP = 3;  // axes of the sensor (x, y, z = 1, 2, 3); -1 is opposite to x
const uint32_t SENSE_US = 5000;       // time between measurements
const uint16_t CALIBRATION = 200;     // measurements whose mean counts as still and level
const float STILL = 0.1;              // rad/s, largest rate in the calibration
const float TILT_TIME = 1;            // s, time constant with which the accelerometer corrects tilt
const uint8_t MPU6050 = 0x68;
const float GYRO = 3.14159265f / 180 / 65.5f;  // rad/s per digit, in the range of 500 degrees per second
float rates[3], up[3];             // rad/s and g, about and along forward, left and up
float bias[3], level_roll, level_pitch;
float sums[6];                     // of rates and accelerations in the calibration
uint16_t measured = 0;             // measurements in the calibration

void write_sensor(uint8_t place, uint8_t value) {
  Wire.beginTransmission(MPU6050);
  Wire.write(place);
  Wire.write(value);
  Wire.endTransmission();
}

void start_sensor() {
  write_sensor(0x6b, 1);     // awake, with the clock of the gyroscope
  write_sensor(0x1a, 3);     // low-pass filter, 42 Hz
  write_sensor(0x1b, 0x08);  // 500 degrees per second
  write_sensor(0x1c, 0x08);  // 4 g
}

float along(const int16_t values[3], int8_t axis) {
  return axis < 0 ? -(float)values[-axis - 1] : (float)values[axis - 1];
}

// Reads rates and acceleration; returns whether the sensor answered.
bool read_sensor() {
  Wire.beginTransmission(MPU6050);
  Wire.write((uint8_t)0x3b);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(MPU6050, (uint8_t)14) != 14) return false;
  int16_t raw[7];
  for (uint8_t i = 0; i < 7; i++) {
    const uint8_t high = Wire.read();
    raw[i] = (int16_t)((uint16_t)high << 8 | (uint8_t)Wire.read());
  }
  const int8_t axes[3] = {FORWARD, LEFT, UP};
  for (uint8_t i = 0; i < 3; i++) {
    up[i] = along(raw, axes[i]) / 8192;
    rates[i] = along(raw + 4, axes[i]) * GYRO - bias[i];
  }
  return true;
}

float roll_of(const float a[3]) { return atan2f(a[1], a[2]); }
float pitch_of(const float a[3]) { return atan2f(-a[0], sqrtf(a[1] * a[1] + a[2] * a[2])); }

void start_calibration() {
  measured = 0;
  for (uint8_t i = 0; i < 6; i++) sums[i] = 0;
  for (uint8_t i = 0; i < 3; i++) bias[i] = 0;
}

// Means of a second at standstill are the bias of the gyroscope and the tilt of the sensor. Returns
// whether the second is over.
bool calibrated() {
  for (uint8_t i = 0; i < 3; i++) {
    sums[i] += rates[i];
    sums[3 + i] += up[i];
  }
  measured++;
  bool still = true;
  for (uint8_t i = 0; i < 3; i++) still &= fabsf(rates[i] - sums[i] / measured) < STILL;
  if (!still) {  // again
    measured = 0;
    for (uint8_t i = 0; i < 6; i++) sums[i] = 0;
    return false;
  }
  if (measured < CALIBRATION) return false;
  for (uint8_t i = 0; i < 3; i++) bias[i] = sums[i] / measured;
  level_roll = roll_of(sums + 3);
  level_pitch = pitch_of(sums + 3);
  return true;
}

// Integrates the rates; the accelerometer corrects roll and pitch slowly.
void integrate(float dt, double angles[3]) {
  double *roll = &angles[0], *pitch = &angles[1];
  const float r = (float)*roll, p = (float)*pitch;
  const float turning = rates[1] * sinf(r) + rates[2] * cosf(r);
  const float share = fminf(dt / TILT_TIME, 1.0f);
  *roll += dt * (rates[0] + turning * tanf(p));
  *pitch += dt * (rates[1] * cosf(r) - rates[2] * sinf(r));
  angles[2] += dt * turning / cosf(p);
  *roll += share * (roll_of(up) - level_roll - *roll);
  *pitch += share * (pitch_of(up) - level_pitch - *pitch);
}
