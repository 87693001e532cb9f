// Runs a sketch. Arguments: the duration in seconds, then pairs of a time in seconds and a command;
// the command b presses the button for 100 ms, !turn X turns the sensor to the left at X rad/s, !roll
// tilts it by a right angle, and !fail disconnects it.
#include <stdlib.h>
#include SKETCH

int main(int count, char **words) {
  setup();
  const uint32_t end = atof(words[1]) * 1000;
  uint32_t release_ms = 0;
  for (clock_ms = 0; clock_ms <= end; clock_ms++) {
    for (int word = 2; word + 1 < count; word += 2) {
      if (clock_ms != (uint32_t)(atof(words[word]) * 1000)) continue;
      if (*words[word + 1] == 'b') {
        button_down = true;
        release_ms = clock_ms + 100;
      } else if (!strncmp(words[word + 1], "!turn", 5)) {
        true_rates[2] = atof(words[word + 1] + 5);
      } else if (!strcmp(words[word + 1], "!roll")) {
        true_rates[0] = 2;
        true_up[1] = 1;
        true_up[2] = 0;
      } else if (!strcmp(words[word + 1], "!fail")) {
        sensor_fails = true;
      } else {
        Serial.waiting = words[word + 1];
      }
    }
    if (clock_ms == release_ms) button_down = false;
    loop();
  }
}
