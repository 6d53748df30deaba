// gpvc with the command line and the files of mvs-texturing's texrecon.
#pragma once

#include "app/texrecon/arguments.h"

namespace gpvc::texrecon {

/// Leaves out each face whose vertices are those of a later face; returns how many. So does texrecon before it numbers faces.
/// O(faces log faces).
std::size_t remove_redundant_faces(Mesh& mesh);

/// Per face 1 if it is written: faces that photos show, all others with `keep_unseen`, and with `fill_holes` those of small areas
/// that photos do not show and that do not touch the mesh's border. O(faces log faces).
std::vector<std::uint8_t> written_faces(const Mesh& mesh, const labeling::FaceGraph& graph,
                                        std::span<const labeling::FaceTag> tags, bool keep_unseen, bool fill_holes);

/// Textures and writes. Throws what the pipeline throws.
void run(const Arguments& arguments);

/// All of main(): reads the words, runs, prints errors. Returns the exit status.
int run_command_line(int argc, char** argv);

}  // namespace gpvc::texrecon
