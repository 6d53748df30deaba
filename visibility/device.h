// OpenGL devices: what this machine has, and a context on one of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "../io/error.h"

namespace gpvc::visibility {

/// An OpenGL or EGL call failed, or there is no device. Says which call or stage, the code and the driver's log.
class GpuError : public Error {
 public:
  using Error::Error;
};

struct DeviceInfo {
  int index = 0;          ///< what GraphicsDevice takes
  std::string renderer;   ///< GL_RENDERER
  std::string driver;     ///< GL_VERSION
  bool software = false;  ///< a CPU rasterizer (llvmpipe)
};

/// Every EGL device on which an OpenGL 4.5 core context can be made, hardware first. Empty when there is none, also when
/// this machine has no EGL.
std::vector<DeviceInfo> list_devices();

/// An OpenGL 4.5 core context without a surface, current on the thread that made it. Use and destroy it on that thread.
/// EGL and OpenGL are looked for at run time, when the first context is made or list_devices() is called.
class GraphicsDevice {
 public:
  /// `device` < 0: the first of list_devices(). Throws GpuError, with a sentence for each EGL step that can fail.
  explicit GraphicsDevice(int device = -1);
  /// The first device of list_devices() if it is graphics hardware, else null. Does not load OpenGL where device files
  /// and drivers show that there can be no hardware.
  static std::unique_ptr<GraphicsDevice> find_hardware();
  ~GraphicsDevice();
  const DeviceInfo& info() const;
  /// Makes the context current again after another one was. Throws GpuError on any thread but its own.
  void make_current() const;

 private:
  struct Context;
  explicit GraphicsDevice(std::unique_ptr<Context> context);
  std::unique_ptr<Context> context_;
};

}  // namespace gpvc::visibility
