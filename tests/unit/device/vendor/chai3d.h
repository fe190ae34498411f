// Declarations of what src/device/chai3d.cpp uses of CHAI3D 3, so that it compiles in the tests. Written for that. Never
// installed, never linked.
#pragma once

#include <memory>
#include <string>

namespace chai3d {

class cVector3d {
public:
    cVector3d();
    cVector3d(double x, double y, double z);
    double operator()(unsigned int component) const;
};

class cMatrix3d {
public:
    double operator()(int row, int column) const;
};

struct cHapticDeviceInfo {
    std::string m_modelName, m_manufacturerName;
    double m_maxLinearForce, m_maxAngularTorque;
    bool m_sensedRotation, m_actuatedPosition, m_actuatedRotation;
};

class cGenericHapticDevice {
public:
    virtual ~cGenericHapticDevice();
    virtual bool open();
    virtual bool close();
    virtual bool calibrate(bool force = false);
    bool enableForces(bool value);
    cHapticDeviceInfo getSpecifications();
    virtual bool getPosition(cVector3d& position);
    virtual bool getRotation(cMatrix3d& rotation);
    virtual bool getLinearVelocity(cVector3d& velocity);
    virtual bool getAngularVelocity(cVector3d& velocity);
    virtual bool getUserSwitches(unsigned int& switches);
    virtual bool setForceAndTorqueAndGripperForce(const cVector3d& force, const cVector3d& torque, double gripper);
};
using cGenericHapticDevicePtr = std::shared_ptr<cGenericHapticDevice>;

class cHapticDeviceHandler {
public:
    cHapticDeviceHandler();
    unsigned int getNumDevices();
    bool getDevice(cGenericHapticDevicePtr& device, unsigned int index = 0);
};

}  // namespace chai3d
