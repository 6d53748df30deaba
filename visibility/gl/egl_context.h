// An OpenGL 4.5 core context from EGL without window, surface or display server.
#pragma once

#include <memory>
#include <vector>

#include "visibility/device.h"

namespace gpvc::visibility {

/// A way to get a context: an EGL device, or Mesa's surfaceless platform.
struct EglPlatform {
  unsigned platform = 0;   ///< EGL_PLATFORM_*
  void* device = nullptr;  ///< EGLDeviceEXT, or nullptr (the default display of the platform)
};

/// Owns an EGL display reference and a context, current on the thread that made it.
class EglContext {
 public:
  /// Throws GpuError naming the EGL call that failed and its code.
  explicit EglContext(const EglPlatform& platform);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes the context current on the calling thread. Throws GpuError when it is current on another one.
  void make_current() const;
  /// GL_RENDERER and GL_VERSION; DeviceInfo::index is left at 0.
  const DeviceInfo& info() const { return info_; }

 private:
  struct Display;
  std::unique_ptr<Display> display_;
  void* context_ = nullptr;
  DeviceInfo info_;
};

struct EglCandidate {
  EglPlatform platform;
  DeviceInfo info;
};

/// The devices of list_devices() with their platforms. `failures`, if given, receives a sentence for each platform on
/// which no context could be made, or for EGL or OpenGL libraries that are not installed.
std::vector<EglCandidate> egl_candidates(std::vector<std::string>* failures = nullptr);

}  // namespace gpvc::visibility
