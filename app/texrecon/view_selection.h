// A model that shows which view each face took.
#pragma once

#include <cstdint>
#include <span>

#include "app/texrecon/view_numbers.h"

namespace gpvc::texrecon {

class PrefixedFiles;  // model_files.h

/// PREFIX_view_selection.obj: the mesh with a colour for each view on the faces that show it. Throws OutputError.
void write_view_selection(PrefixedFiles& files, const Mesh& mesh, std::span<const ViewId> labels,
                          const ViewNumbers& numbers, std::span<const std::uint8_t> written);

}  // namespace gpvc::texrecon
