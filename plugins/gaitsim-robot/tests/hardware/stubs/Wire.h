// An I2C bus with an MPU6050 at 0x68, which the test moves.
#pragma once
#include <Arduino.h>

static float true_rates[3] = {0, 0, 0};  // rad/s
static float true_up[3] = {0, 0, 1};     // g
static float gyro_bias = 0.05;           // rad/s
static bool sensor_fails = false;

struct TwoWire {
  uint8_t buffer[14];
  uint8_t place = 0;
  void begin() {}
  void setClock(unsigned long) {}
  void beginTransmission(uint8_t) {}
  size_t write(uint8_t) { return 1; }
  uint8_t endTransmission(bool = true) { return sensor_fails ? 2 : 0; }
  uint8_t requestFrom(uint8_t, uint8_t) {
    for (int i = 0; i < 7; i++) {
      const float value = i < 3    ? true_up[i] * 8192
                          : i == 3 ? 0
                                   : (true_rates[i - 4] + gyro_bias) * 65.5f * 180 / 3.14159265f;
      const int16_t rounded = (int16_t)lrintf(value);
      buffer[2 * i] = (uint8_t)((uint16_t)rounded >> 8);
      buffer[2 * i + 1] = (uint8_t)(rounded & 255);
    }
    place = 0;
    return sensor_fails ? 0 : 14;
  }
  int read() { return buffer[place++]; }
};
static TwoWire Wire;
