// The two files of an editable result, with which retexture_into() changes a part of it: what the views see of each face, and
// how the faces are textured. Both are results as io::WorkStore keeps them, so one that is damaged or of another format is
// told from a good one. The values are those of this machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "app/pipeline/coverage_store.h"
#include "app/pipeline/keys.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/options.h"
#include "io/scene_members.h"

namespace gpvc::pipeline {

inline constexpr const char* kEditViewsFile = "edit-views.bin";
inline constexpr const char* kEditModelFile = "edit-model.bin";

/// How the faces of a result are textured.
struct EditModel {
  ResultKeys keys;
  std::vector<ViewRule> rules;
  std::vector<ViewId> labels;
  io::TexturedModel model;  ///< without its mesh
  std::vector<std::array<int, 2>> page_sizes;
  std::vector<std::uint32_t> face_chart;  ///< per face; numbers may have gaps
  std::vector<atlas::ViewExposure> exposure;
  double reduction = 1;
};
GPVC_MEMBERS(EditModel, keys, rules, labels, model, page_sizes, face_chart, exposure, reduction)

/// Write into the folder. 20 bytes for each face and view that sees it, and the coverage of those that see it in part; some 30
/// bytes a face. Throw OutputError.
void write_edit_views(const Input& input, const ResultKeys& keys, const labeling::CandidateCollector& collector,
                      const CoverageStore& coverage, OutputFolder& folder);
void write_edit_model(const EditModel& model, OutputFolder& folder);

/// Throws InputError where `from` holds no editable result of this format.
EditModel read_edit_model(const std::filesystem::path& from);
/// Adds all views, and takes over how they were judged. Throws InputError.
void read_edit_views(const std::filesystem::path& from, const Input& input, const ResultKeys& keys,
                     labeling::CandidateCollector& collector, CoverageStore& coverage);

/// Bytes of both files, predicted.
double edit_bytes(const Workload& work);

}  // namespace gpvc::pipeline
