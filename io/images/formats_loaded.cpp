// For programs, and for the shared library, which find the module by their RUNPATH.
#include "io/error.h"
#include "io/files/module.h"
#include "io/images/other_formats.h"

namespace gpvc::io {

const OtherFormats& other_formats(const std::filesystem::path& file) {
  static const auto module = open_module<OtherFormats>(GPVC_FORMATS_MODULE, "gpvc_other_formats");
  if (module.functions == nullptr)
    throw InputError(
        file, "", "is neither JPEG nor PNG, and the module that reads other formats cannot be opened: " + module.why);
  return *module.functions;
}

}  // namespace gpvc::io
