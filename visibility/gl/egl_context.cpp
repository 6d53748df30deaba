// OpenGL 4.5 core contexts from EGL, without window, surface or display server.

#include <dlfcn.h>
#include <epoxy/egl.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "visibility/device.h"
#include "visibility/gl/gl_objects.h"

namespace gpvc::visibility {
namespace {

/// The libraries that libepoxy loads at its first call, and ends the process without: empty if they are there, else a
/// sentence. They stay loaded.
std::string missing_libraries() {
  const auto loads = [](const char* library) { return dlopen(library, RTLD_LAZY | RTLD_LOCAL) != nullptr; };
  static const std::string missing = [&]() -> std::string {
    if (!loads("libEGL.so.1")) return "libEGL.so.1 is not installed (Debian: libegl1, libgl1-mesa-dri)";
    if (!loads("libGL.so.1") && !loads("libOpenGL.so.0"))
      return "neither libGL.so.1 nor libOpenGL.so.0 is installed (Debian: libgl1 or libopengl0)";
    return {};
  }();
  return missing;
}

std::string egl_error_name(EGLint code) {
  constexpr std::pair<EGLint, const char*> kNames[] = {
      {EGL_SUCCESS, "EGL_SUCCESS"},
      {EGL_NOT_INITIALIZED, "EGL_NOT_INITIALIZED"},
      {EGL_BAD_ACCESS, "EGL_BAD_ACCESS"},
      {EGL_BAD_ALLOC, "EGL_BAD_ALLOC"},
      {EGL_BAD_ATTRIBUTE, "EGL_BAD_ATTRIBUTE"},
      {EGL_BAD_CONFIG, "EGL_BAD_CONFIG"},
      {EGL_BAD_CONTEXT, "EGL_BAD_CONTEXT"},
      {EGL_BAD_DISPLAY, "EGL_BAD_DISPLAY"},
      {EGL_BAD_MATCH, "EGL_BAD_MATCH"},
      {EGL_BAD_PARAMETER, "EGL_BAD_PARAMETER"},
      {EGL_CONTEXT_LOST, "EGL_CONTEXT_LOST"},
  };
  for (const auto& [known, name] : kNames)
    if (known == code) return name;
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "0x%04x", static_cast<unsigned>(code));
  return text.data();
}

GpuError egl_failure(const std::string& call, const std::string& meaning) {
  return GpuError(call + " failed with " + egl_error_name(eglGetError()) + ": " + meaning);
}

/// `name` as a whole word of the blank-separated list.
bool has_extension(const char* list, std::string_view name) {
  std::string_view rest = list != nullptr ? list : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

template <class Function>
Function egl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

/// A way to get a context: an EGL device, or Mesa's surfaceless platform.
struct EglPlatform {
  EGLenum platform = 0;           ///< EGL_PLATFORM_*
  EGLDeviceEXT device = nullptr;  ///< nullptr: the default display of the platform
};

EGLDisplay open_display(const EglPlatform& platform) {
  const auto get_display = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr)
    throw GpuError("eglGetPlatformDisplayEXT is missing: this EGL has no EGL_EXT_platform_base");
  void* native = platform.device != nullptr ? platform.device : static_cast<void*>(EGL_DEFAULT_DISPLAY);
  const EGLDisplay display = get_display(platform.platform, native, nullptr);
  if (display == EGL_NO_DISPLAY) throw egl_failure("eglGetPlatformDisplayEXT", "the device has no display");
  return display;
}

/// EGL has one display per device, shared by all callers, and eglTerminate ends it for all of them.
std::mutex display_mutex;
std::map<EGLDisplay, int>& display_users() {
  static std::map<EGLDisplay, int> users;
  return users;
}

EGLContext create_context(EGLDisplay display) {
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_no_config_context")) {
    const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    EGLint count = 0;
    if (!eglChooseConfig(display, wanted.data(), &config, 1, &count) || count == 0)
      throw egl_failure("eglChooseConfig", "the device has no configuration for desktop OpenGL");
  }
  const std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,       4,
                                       EGL_CONTEXT_MINOR_VERSION,       5,
                                       EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
  const auto made_with = [&](std::initializer_list<EGLint> more) {
    std::vector<EGLint> all = attributes;
    all.insert(all.end(), more);
    all.push_back(EGL_NONE);
    return eglCreateContext(display, config, EGL_NO_CONTEXT, all.data());
  };
  // After a device reset buffers hold garbage. A context that is lost on reset reports it (check_gl()).
  EGLContext context = made_with({EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  if (context == EGL_NO_CONTEXT) context = made_with({});  // EGL 1.4, or a driver that does not report resets
  if (context == EGL_NO_CONTEXT)
    throw egl_failure("eglCreateContext", "the driver cannot make an OpenGL 4.5 core context");
  return context;
}

std::string gl_string(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text != nullptr ? text : "";
}

bool is_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "SWR", "Software Rasterizer", "SwiftShader", "lavapipe"})
    if (renderer.find(name) != std::string::npos) return true;
  return false;
}

/// A reference to the display of a platform.
struct EglDisplay {
  explicit EglDisplay(const EglPlatform& platform) : handle(open_display(platform)) {
    const std::lock_guard lock(display_mutex);
    if (!eglInitialize(handle, nullptr, nullptr))
      throw egl_failure("eglInitialize", "the driver of this device cannot be initialized");
    ++display_users()[handle];
  }
  ~EglDisplay() {
    const std::lock_guard lock(display_mutex);
    if (--display_users()[handle] == 0) eglTerminate(handle);
  }
  EglDisplay(const EglDisplay&) = delete;
  EglDisplay& operator=(const EglDisplay&) = delete;
  EGLDisplay handle;
};

/// A context, current on the thread that made it.
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
  EglDisplay display_;
  EGLContext context_ = nullptr;
  DeviceInfo info_;
};

EglContext::EglContext(const EglPlatform& platform) : display_(platform) {
  const EGLDisplay display = display_.handle;
  if (!has_extension(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    throw GpuError("EGL_KHR_surfaceless_context is missing: this driver cannot render without a window");
  if (!eglBindAPI(EGL_OPENGL_API)) throw egl_failure("eglBindAPI", "the driver has no desktop OpenGL");
  context_ = create_context(display);
  try {
    make_current();
    info_.renderer = gl_string(GL_RENDERER);
    info_.driver = gl_string(GL_VERSION);
    info_.software = is_software(info_.renderer);
    if (info_.renderer.empty())
      throw GpuError("glGetString(GL_RENDERER) is empty: OpenGL calls reach no driver for this context");
  } catch (...) {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context_);
    throw;
  }
}

EglContext::~EglContext() {
  const EGLDisplay display = display_.handle;
  if (eglGetCurrentContext() == context_) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context_);
}

void EglContext::make_current() const {
  eglBindAPI(EGL_OPENGL_API);
  if (eglGetCurrentContext() == context_) return;
  if (!eglMakeCurrent(display_.handle, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
    throw egl_failure("eglMakeCurrent", "the context is current on another thread, or lost");
}

std::vector<EglPlatform> egl_platforms() {
  std::vector<EglPlatform> platforms;
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool enumerates =
      has_extension(extensions, "EGL_EXT_device_enumeration") || has_extension(extensions, "EGL_EXT_device_base");
  const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (enumerates && has_extension(extensions, "EGL_EXT_platform_device") && query_devices != nullptr) {
    EGLint count = 0;
    if (query_devices(0, nullptr, &count) && count > 0) {
      std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
      if (query_devices(count, devices.data(), &count)) {
        devices.resize(static_cast<std::size_t>(count));
        for (const EGLDeviceEXT device : devices) platforms.push_back({EGL_PLATFORM_DEVICE_EXT, device});
      }
    }
  }
  if (has_extension(extensions, "EGL_MESA_platform_surfaceless"))
    platforms.push_back({EGL_PLATFORM_SURFACELESS_MESA, nullptr});
  return platforms;
}

/// Restores the context that was current before, since probing makes others current.
class CurrentContextGuard {
 public:
  CurrentContextGuard() : display_(eglGetCurrentDisplay()), context_(eglGetCurrentContext()) {}
  ~CurrentContextGuard() {
    if (context_ != EGL_NO_CONTEXT) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  CurrentContextGuard(const CurrentContextGuard&) = delete;
  CurrentContextGuard& operator=(const CurrentContextGuard&) = delete;

 private:
  EGLDisplay display_;
  EGLContext context_;
};

struct EglCandidate {
  EglPlatform platform;
  DeviceInfo info;
};

/// The devices of list_devices() with their platforms. `failures`, if given, receives a sentence for each platform on
/// which no context could be made, or for EGL or OpenGL libraries that are not installed.
std::vector<EglCandidate> egl_candidates(std::vector<std::string>* failures = nullptr) {
  if (const std::string missing = missing_libraries(); !missing.empty()) {
    if (failures != nullptr) failures->push_back(missing);
    return {};
  }
  const CurrentContextGuard guard;
  std::vector<EglCandidate> found;
  for (const EglPlatform& platform : egl_platforms()) {
    try {
      const EglContext context(platform);
      // The surfaceless platform reaches a device that the enumeration may have listed already.
      const bool listed =
          platform.device == nullptr && std::any_of(found.begin(), found.end(), [&](const EglCandidate& other) {
            return other.info.renderer == context.info().renderer;
          });
      if (!listed) found.push_back({platform, context.info()});
    } catch (const GpuError& error) {
      if (failures != nullptr) failures->emplace_back(error.what());
    }
  }
  std::stable_partition(found.begin(), found.end(),
                        [](const EglCandidate& candidate) { return !candidate.info.software; });
  for (std::size_t i = 0; i < found.size(); ++i) found[i].info.index = static_cast<int>(i);
  return found;
}

/// True only if every EGL driver is Mesa's and there are no device files that its hardware drivers could open.
bool surely_no_hardware() {
  namespace fs = std::filesystem;
  for (const char* variable : {"__EGL_VENDOR_LIBRARY_FILENAMES", "__EGL_VENDOR_LIBRARY_DIRS"})
    if (std::getenv(variable) != nullptr) return false;
  std::error_code failed;
  std::size_t mesa = 0;
  for (const char* folder : {"/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d"})
    for (fs::directory_iterator file(folder, failed), end; file != end; file.increment(failed)) {
      if (file->path().filename().string().find("mesa") == std::string::npos) return false;
      ++mesa;
    }
  if (mesa == 0) return false;
  for (const char* path : {"/dev/dxg", "/dev/kgsl-3d0", "/dev/nvidiactl"})
    if (fs::exists(path, failed) || failed) return false;
  return fs::directory_iterator("/dev/dri", failed) == fs::directory_iterator();
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> devices;
  for (EglCandidate& candidate : egl_candidates()) devices.push_back(std::move(candidate.info));
  return devices;
}

struct GraphicsDevice::Context {
  explicit Context(const EglCandidate& candidate) : egl(candidate.platform), info(candidate.info) {}
  EglContext egl;
  DeviceInfo info;
};

GraphicsDevice::GraphicsDevice(int device) {
  std::vector<std::string> failures;
  const std::vector<EglCandidate> candidates = egl_candidates(&failures);
  if (candidates.empty()) {
    std::string reasons;
    for (const std::string& failure : failures) reasons.append(reasons.empty() ? ": " : "; ").append(failure);
    throw GpuError(
        "no EGL device can make an OpenGL 4.5 core context (without a GPU driver, install Mesa's software renderer; "
        "Debian: libegl1, libgl1-mesa-dri)" +
        reasons);
  }
  const std::size_t chosen = device < 0 ? 0 : static_cast<std::size_t>(device);
  if (chosen >= candidates.size())
    throw GpuError("device " + std::to_string(device) + " does not exist: devices are numbered 0 to " +
                   std::to_string(candidates.size() - 1));
  context_ = std::make_unique<Context>(candidates[chosen]);
}

GraphicsDevice::GraphicsDevice(std::unique_ptr<Context> context) : context_(std::move(context)) {}

std::unique_ptr<GraphicsDevice> GraphicsDevice::find_hardware() {
  if (surely_no_hardware()) return nullptr;
  const std::vector<EglCandidate> candidates = egl_candidates();
  if (candidates.empty() || candidates.front().info.software) return nullptr;
  return std::unique_ptr<GraphicsDevice>(new GraphicsDevice(std::make_unique<Context>(candidates.front())));
}

GraphicsDevice::~GraphicsDevice() = default;
const DeviceInfo& GraphicsDevice::info() const { return context_->info; }
void GraphicsDevice::make_current() const { context_->egl.make_current(); }

}  // namespace gpvc::visibility
