#include "app/pipeline/edit_files.h"

#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

#include "app/pipeline/agreement_bytes.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

// To be raised when anything that the files hold, as labeling::FaceRecord, takes another form or meaning.
constexpr std::uint32_t kFormat = 2;

io::WorkKey model_key() {
  io::WorkHash hash;
  hash.add_text("gpvc edit");
  hash.add(kFormat);
  return hash.key();
}

// The views belong to the model beside them.
io::WorkKey views_key(const ResultKeys& keys) {
  io::WorkHash hash;
  hash.add(model_key().bits);
  for (const io::WorkKey& key : {keys.mesh, keys.views, keys.options}) hash.add(key.bits);
  return hash.key();
}

void write_result(const char* name, const io::WorkKey& key, OutputFolder& folder,
                  const std::function<void(io::WorkStore::Writer&)>& write) {
  folder.file(name);
  io::WorkStore store(folder.in_making());
  store.keep(name, key, write);
  if (const auto failure = store.failure()) throw OutputError(folder.path() / name, *failure);
}

void read_result(const fs::path& from, const char* name, const io::WorkKey& key,
                 const std::function<void(io::WorkStore::Reader&)>& read) {
  const io::WorkStore store(from);
  if (!fs::exists(from / "model.obj")) throw InputError(from, "", "holds no textured model (model.obj)");
  if (!fs::exists(from / name))
    throw InputError(from / name, "", "is missing, without which the result cannot be changed", {Cure::make_editable});
  if (!store.has(name, key))
    throw InputError(from / name, "", "is of another version of gpvc, or of another result", {Cure::make_editable});
  if (!store.read(name, key, read)) throw InputError(from / name, "", "is damaged", {Cure::make_editable});
}

void write_rule(const ViewRule& rule, io::WorkStore::Writer& out) {
  out.add(rule.region.index());
  if (const auto* box = std::get_if<io::BoxRegion>(&rule.region)) {
    out.add(*box);
  } else if (const auto* ground = std::get_if<io::GroundRegion>(&rule.region)) {
    out.add_all(ground->corners);
    out.add(ground->low);
    out.add(ground->high);
  } else {
    out.add_all(std::get<io::FaceRegion>(rule.region).ranges);
  }
  out.add(rule.allow);
  out.add_all(rule.views);
}

ViewRule read_rule(io::WorkStore::Reader& in) {
  ViewRule rule;
  switch (in.get<std::size_t>()) {
    case 0:
      rule.region = in.get<io::BoxRegion>();
      break;
    case 1: {
      io::GroundRegion ground;
      ground.corners = in.get_all<std::array<double, 2>>();
      ground.low = in.get<double>();
      ground.high = in.get<double>();
      rule.region = std::move(ground);
      break;
    }
    case 2:
      rule.region = io::FaceRegion{in.get_all<std::array<std::uint32_t, 2>>()};
      break;
    default:
      in.refuse();
  }
  rule.allow = in.get<bool>();
  rule.views = in.get_all<ViewId>();
  return rule;
}

}  // namespace

void write_edit_views(const Input& input, const ResultKeys& keys, const labeling::CandidateCollector& collector,
                      const CoverageStore& coverage, OutputFolder& folder) {
  write_result(kEditViewsFile, views_key(keys), folder, [&](io::WorkStore::Writer& out) {
    for (const ViewId id : input.views) out.add_all(collector.statistics_of(id));
    write_agreement(out, collector.agreement());
    out.add(coverage.views().size());
    for (const auto& packed : coverage.views()) {
      out.add(packed->view);
      out.add_all(packed->bytes);
    }
  });
}

void read_edit_views(const fs::path& from, const Input& input, const ResultKeys& keys,
                     labeling::CandidateCollector& collector, CoverageStore& coverage) {
  read_result(from, kEditViewsFile, views_key(keys), [&](io::WorkStore::Reader& in) {
    for (const ViewId id : input.views)
      if (!collector.add_statistics(id, in.get_all<std::byte>())) in.refuse();
    collector.take_judgement(read_agreement(in));
    for (auto left = in.get<std::size_t>(); left > 0; --left) {
      const auto view = in.get<ViewId>();
      coverage.add(std::make_shared<const PackedCoverage>(PackedCoverage{view, in.get_all<std::uint8_t>()}));
    }
  });
}

void write_edit_model(const EditModel& m, OutputFolder& folder) {
  write_result(kEditModelFile, model_key(), folder, [&](io::WorkStore::Writer& out) {
    for (const io::WorkKey& key : {m.keys.mesh, m.keys.views, m.keys.options}) out.add(key);
    out.add(m.rules.size());
    for (const ViewRule& rule : m.rules) write_rule(rule, out);
    out.add_all(m.labels);
    out.add_all(m.model.texcoords);
    out.add_all(m.model.face_texcoords);
    out.add_all(m.model.face_page);
    out.add_all(m.page_sizes);
    out.add_all(m.face_chart);
    out.add_all(m.exposure);
    out.add(m.reduction);
  });
}

EditModel read_edit_model(const fs::path& from) {
  EditModel m;
  read_result(from, kEditModelFile, model_key(), [&](io::WorkStore::Reader& in) {
    for (io::WorkKey* key : {&m.keys.mesh, &m.keys.views, &m.keys.options}) *key = in.get<io::WorkKey>();
    for (auto left = in.get<std::size_t>(); left > 0; --left) m.rules.push_back(read_rule(in));
    m.labels = in.get_all<ViewId>();
    m.model.texcoords = in.get_all<io::TexCoord>();
    m.model.face_texcoords = in.get_all<Triangle>();
    m.model.face_page = in.get_all<std::uint32_t>();
    m.page_sizes = in.get_all<std::array<int, 2>>();
    m.face_chart = in.get_all<std::uint32_t>();
    m.exposure = in.get_all<atlas::ViewExposure>();
    m.reduction = in.get<double>();
  });
  return m;
}

double edit_bytes(const Workload& work) {
  // A record, and coverage of partial faces, of which there are few; of a face its label, corners, page, chart and its share
  // of texture coordinates.
  return 24 * work.pairs + 32 * work.faces;
}

}  // namespace gpvc::pipeline
