// Declarations of what src/device/force_dimension.cpp uses of the Force Dimension SDK, so that it compiles in the tests. Written
// for that. Never installed, never linked.
#pragma once

#define DHD_ON 1
#define DHD_OFF 0

extern "C" {
int dhdGetDeviceCount();
int dhdOpenID(char index);
int dhdClose(char id);
const char* dhdErrorGetLastStr();
const char* dhdGetSystemName(char id);
bool dhdHasWrist(char id);
bool dhdHasActiveWrist(char id);
int dhdEnableForce(unsigned char on, char id);
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double rotation[3][3], char id);
int dhdGetLinearVelocity(double* x, double* y, double* z, char id);
int dhdGetAngularVelocityRad(double* x, double* y, double* z, char id);
unsigned int dhdGetButtonMask(char id);
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double gripper,
                                        char id);
void dhdSleep(double seconds);
}
