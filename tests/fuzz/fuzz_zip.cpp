#include "fuzz.h"
#include "io/files/zip_file.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(zip) {
  return reads_or_refuses([&] {
    const std::filesystem::path file = folder() / "a.zip";
    const io::ZipFile archive(file, view(data, size));
    for (const auto& [member, number] : archive.members())
      if (archive.read(member, 5).size() > archive.read(member).size()) std::abort();
  });
}

}  // namespace gpvc::fuzz
