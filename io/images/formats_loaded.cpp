// For programs, and for the shared library, which find the module by their RUNPATH.
#include <dlfcn.h>

#include <string>

#include "io/error.h"
#include "io/images/other_formats.h"

namespace gpvc::io {
namespace {

struct Module {
  const OtherFormats* formats = nullptr;
  std::string why;  ///< there are none
};

Module load() {
  void* module = ::dlopen(GPVC_FORMATS_MODULE, RTLD_NOW | RTLD_LOCAL);  // stays open to the end
  using Entry = decltype(&gpvc_other_formats);
  if (module != nullptr)
    if (const auto entry = reinterpret_cast<Entry>(::dlsym(module, "gpvc_other_formats"))) return {entry(), ""};
  const char* why = ::dlerror();
  return {nullptr, why == nullptr ? GPVC_FORMATS_MODULE : why};
}

}  // namespace

const OtherFormats& other_formats(const std::filesystem::path& file) {
  static const Module module = load();
  if (module.formats == nullptr)
    throw InputError(
        file, "", "is neither JPEG nor PNG, and the module that reads other formats cannot be opened: " + module.why);
  return *module.formats;
}

}  // namespace gpvc::io
