// A board that prints each command: milliseconds, address, channel, ticks.
#pragma once
#include <Arduino.h>

struct Adafruit_PWMServoDriver {
  uint8_t address;
  explicit Adafruit_PWMServoDriver(uint8_t given) : address(given) {}
  void begin() {}
  void setOscillatorFrequency(uint32_t) {}
  void setPWMFreq(float) {}
  uint8_t setPWM(uint8_t channel, uint16_t on, uint16_t off) {
    printf("%u %u %u %u\n", (unsigned)clock_ms, address, channel, on ? 9999 : off);
    return 0;
  }
};
