// What the parts of the efficiency benchmark share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "visibility/method.h"
#include "visibility/result.h"

namespace gpvc::efficiency {

struct BenchScene {
  std::string name;
  Mesh mesh;
  std::vector<View> views;
};

/// A manifold height field of 611,618 faces, 400 m wide: uneven ground with blocks of buildings, and 43 views of 4000 x
/// 3000 pixels, 11 nadir and 8 oblique from each of four sides, that see about half of it each.
BenchScene generated_scene();

/// `MODE[/off|/paper|/exact][/cpu|/gpu][/opengl|/native]`: a visibility mode, and for the gpvc modes what else to set.
struct Row {
  std::string name;
  visibility::VisibilityOptions options;
};
Row parse_row(const std::string& name);

/// Sampling and coverage correction of a gpvc method; no correction for the others.
struct GpvcRow {
  visibility::Sampling sampling{};
  const char* correction = nullptr;
};
GpvcRow gpvc_row(const visibility::Method& method);

/// What one mode did to all views.
struct Measured {
  Row row;
  std::string processor;  ///< "cpu" or "gpu"
  std::string drawing;    ///< "opengl" or "native"
  visibility::VisibilityStatistics sum;
  double total_s = 0;  ///< wall, all in: making the stage, then every view
  double start_s = 0;  ///< of that, making the stage
  double cpu_s = 0;    ///< of all threads meanwhile
  /// Classes unlike those of the first row.
  std::size_t unlike_first = 0;
};

/// Runs every row over every view; progress on stderr. `differing`: faces whose class under HIVERS is not that under
/// dense sampling with the same correction and processor, over all views.
std::vector<Measured> measure(visibility::GraphicsDevice& device, const BenchScene& scene, const std::vector<Row>& rows,
                              std::size_t& differing);

/// Tables 7 to 9 as Markdown on stdout, and table7.csv to table9.csv in `folder` unless that is empty.
void print_tables(const BenchScene& scene, const std::vector<Measured>& measured, const std::filesystem::path& folder);

}  // namespace gpvc::efficiency
