// The monitor of SimpleFOC's library on a computer: what it prints for target and angle of each line of standard input, in radians.
//
// How it is compiled stands in README.md.
#include "BLDCMotor.h"
#include "communication/SimpleFOCDebug.h"
#include <cstdio>
#include <cstring>
#include <iostream>

int main(int, char **words) {
    bool all = !strcmp(words[1], "all"), arduino = !strcmp(words[1], "arduino");
    Print port;
    BLDCMotor motor(7);
    motor.useMonitoring(port);
    SimpleFOCDebug::println(F("MOT: Init"));
    SimpleFOCDebug::println(F("MOT: Align sensor."));
    SimpleFOCDebug::println(F("MOT: Ready."));
    motor.monitor_downsample = 1;
    motor.monitor_variables = all ? 0x7f : motor.monitor_variables;
    if (all) motor.monitor_start_char = motor.monitor_end_char = 'M';
    double target, angle;
    for (int row = 0; std::cin >> target >> angle; row++) {
        motor.target = target;
        motor.shaft_angle = angle;
        // The Arduino IDE's serial monitor with its time stamps puts this before each line.
        if (arduino) printf("%s.%03d -> ", row < 200 ? "23:59:59" : "00:00:00", row % 200 * 5);
        motor.monitor();
    }
}
