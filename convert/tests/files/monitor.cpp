// SimpleFOC's library on a computer, with a motor that is simulated: what its monitor prints. README.md says how it is compiled.
//
// Standard input names one of seven logs. `plain`, `arduino` and `all` print the target and the angle that stand in each further line, in
// radians. `loop`, `currents`, `angle` and `open` run the library's loop, as the examples that it comes with do, with the motor below.
#include "BLDCMotor.h"
#include "communication/Commander.h"
#include "communication/SimpleFOCDebug.h"
#include "current_sense/GenericCurrentSense.h"
#include "drivers/BLDCDriver3PWM.h"
#include "sensors/GenericSensor.h"
#include <cstdio>
#include <iostream>
#include <string>

const double TURN = 2 * M_PI, SUPPLY_V = 12;
const int PAIRS = 7, PINS[3] = {9, 10, 11};
// A gimbal motor with a flywheel: ohms of a winding, volts a rad/s, kg m^2, N m a rad/s. The magnet of its sensor, 14 bits, is beside the
// axis: it reads OFF_RAD sin(shaft - AT_RAD) too much.
const double OHM = 5, BEMF_V_S = 0.04, INERTIA = 4e-4, FRICTION = 2e-5, OFF_RAD = 0.02, AT_RAD = 0.7;

double clock_s, shaft_rad = 1, speed_rad_s, duty[3], amperes[3];
// True of a sensor that is mounted the other way round.
bool mirrored;

// The motor for a while; its inductance is left out.
void turn_on(double step_s) {
    double torque = 0, mean = (duty[0] + duty[1] + duty[2]) / 3;
    for (int phase = 0; phase < 3; phase++) {
        double winding = -sin(PAIRS * shaft_rad - phase * TURN / 3);
        amperes[phase] = ((duty[phase] - mean) * SUPPLY_V - BEMF_V_S * speed_rad_s * winding) / OHM;
        torque += BEMF_V_S * winding * amperes[phase];
    }
    speed_rad_s += (torque - FRICTION * speed_rad_s) / INERTIA * step_s;
    shaft_rad += speed_rad_s * step_s;
    clock_s += step_s;
}

float read_angle() {
    double read = (shaft_rad + OFF_RAD * sin(shaft_rad - AT_RAD)) / TURN * (mirrored ? -1 : 1);
    return floor((read - floor(read)) * 16384) / 16384 * TURN;
}
PhaseCurrent_s read_currents() { return {(float)amperes[0], (float)amperes[1], (float)amperes[2]}; }

// What the user types, and when.
std::string typed;
Port Serial;
size_t Port::write(uint8_t letter) { return putchar(letter) == letter; }
int Port::available() { return typed.size(); }
int Port::peek() { return typed.empty() ? -1 : typed[0]; }
int Port::read() {
    int letter = peek();
    typed.erase(0, 1);
    return letter;
}
extern "C" {
void analogWrite(pin_size_t pin, int value) {
    for (int phase = 0; phase < 3; phase++)
        if (PINS[phase] == pin) duty[phase] = value / 255.0;
}
void pinMode(pin_size_t, PinMode) {}
void digitalWrite(pin_size_t, PinStatus) {}
unsigned long micros() { return clock_s * 1e6; }
unsigned long millis() { return clock_s * 1e3; }
void delay(unsigned long ms) {
    for (unsigned long step = 0; step < 10 * ms; step++) turn_on(1e-4);
}
void delayMicroseconds(unsigned us) { turn_on(us * 1e-6); }
}

BLDCMotor motor(PAIRS);
BLDCDriver3PWM driver(PINS[0], PINS[1], PINS[2]);
GenericSensor sensor(read_angle);
GenericCurrentSense currents(read_currents);
Commander commander(Serial);

void setup_motor() {
    sensor.init();
    motor.linkSensor(&sensor);
    driver.voltage_power_supply = SUPPLY_V;
    driver.init();
    motor.linkDriver(&driver);
    motor.useMonitoring(Serial);
    motor.voltage_limit = 6;
    motor.init();
}

// The library's loop for a while, 1000 times a second.
void run(double length_s) {
    for (double end_s = clock_s + length_s; clock_s < end_s;) {
        motor.loopFOC();
        motor.move();
        motor.monitor();
        commander.run();
        delay(1);
    }
}

int main() {
    std::string mode;
    std::cin >> mode;
    commander.add('M', [](char *command) { commander.motor(&motor, command); }, "motor");
    commander.add('T', [](char *command) { commander.scalar(&motor.target, command); }, "target");
    if (mode == "plain" || mode == "arduino" || mode == "all") {
        motor.monitor_downsample = 1;
        setup_motor();
        motor.initFOC();
        if (mode == "all") {
            motor.monitor_variables = 0x7f;
            motor.monitor_start_char = motor.monitor_end_char = 'M';
        }
        double target, angle;
        for (int row = 0; std::cin >> target >> angle; row++) {
            motor.target = target;
            motor.shaft_angle = angle;
            motor.voltage = {0, 0};
            motor.shaft_velocity = 0;
            // The Arduino IDE's serial monitor with its time stamps puts this before each line.
            if (mode == "arduino") printf("%s.%03d -> ", row < 200 ? "23:59:59" : "00:00:00", row % 200 * 5);
            motor.monitor();
        }
        return 0;
    }
    motor.monitor_downsample = 20;
    motor.controller = MotionControlType::torque;
    motor.monitor_variables = _MON_TARGET | _MON_VEL | _MON_ANGLE;
    if (mode == "currents") {
        currents.init();
        motor.linkCurrentSense(&currents);
        motor.monitor_variables = _MON_TARGET | _MON_CURR_Q | _MON_CURR_D | _MON_VEL | _MON_ANGLE;
        motor.monitor_start_char = motor.monitor_end_char = 'M';
        motor.monitor_separator = ';';
        motor.monitor_decimals = 6;
    }
    if (mode == "angle") {
        motor.monitor_variables = _MON_ANGLE;
        mirrored = true;
    }
    if (mode == "open") motor.controller = MotionControlType::velocity_openloop;
    setup_motor();
    motor.initFOC();
    Serial.println(F("Motor ready."));
    Serial.println(F("Set the target using serial terminal:"));
    double length_s = mode == "loop" ? 10 : 0.6;
    typed = mode == "open" ? "T6\n" : "T0.25\n";
    run(length_s);
    typed = mode == "open" ? "M3\n" : mode == "angle" ? "T0.4\n" : "M0.4\n";
    run(length_s);
}
