// Runs the receiver's sketch. Each line of the input is a time in ms, and bytes in hexadecimal that
// arrive then; ! tilts the robot by a right angle.
#include <stdlib.h>
#include SKETCH

int main() {
  setup();
  static char line[2048], bytes[1024];
  while (fgets(line, sizeof line, stdin)) {
    char *word;
    const uint32_t until = strtoul(line, &word, 10);
    for (; clock_ms < until; clock_ms++) loop();
    word++;
    if (*word == '!') {
      true_up[1] = 1;
      true_up[2] = 0;
      continue;
    }
    size_t count = 0;
    for (; word[0] > ' ' && word[1] > ' '; word += 2) {
      const char digits[3] = {word[0], word[1], 0};
      bytes[count++] = (char)strtol(digits, nullptr, 16);
    }
    Serial.waiting = bytes;
    Serial.bytes = count;
    loop();
    Serial.waiting = "";
  }
}
