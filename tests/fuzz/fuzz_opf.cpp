#include "fuzz_scene.h"

namespace gpvc::fuzz {

// Five files in one input; the project names the others.
GPVC_FUZZ_TARGET(opf) {
  std::string_view rest = view(data, size);
  for (const char* name : {"project.opf", "list.json", "input.json", "calibrated.json", "frame.json"}) {
    const auto parts = halves(rest);
    write(name, parts[0]);
    rest = parts[1];
  }
  for (const io::SceneFormat* format : io::scene_formats())
    if (format->name == std::string_view("OPF"))
      return reads_or_refuses([&] { expect_sound(format->read(folder() / "project.opf")); });
  std::abort();
}

}  // namespace gpvc::fuzz
