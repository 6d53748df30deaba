// For static libraries, which OpenImageIO is linked to.
#include "io/images/other_formats.h"

namespace gpvc::io {

const OtherFormats& other_formats(const std::filesystem::path&) { return *gpvc_other_formats(); }

}  // namespace gpvc::io
