#include "visibility/gl/classify_gl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "io/clock.h"

namespace gpvc::visibility {
namespace {

constexpr GLuint kGroup = 64;  // local_size_x of all programs but candidate_faces.comp
constexpr GLuint kTile = 16;   // local_size of candidate_faces.comp in both directions
/// Faces or vertices per dispatch: stays below 65536 work groups, which every device allows.
constexpr std::size_t kMostPerDispatch = std::size_t{1} << 21;
/// Buffer ranges start at multiples of 256 bytes, the largest alignment that a device may require.
constexpr std::size_t kAlignment = 256;
constexpr std::size_t kProjectedBytes = 3 * sizeof(double);
/// Work groups that share the large faces, each group taking one face after another: enough to fill any device.
constexpr GLuint kLargeGroups = 1024;

enum TextureUnit : GLuint { kIvm, kMask, kVertices, kCorners, kTiles };

/// The largest multiple of the alignment that is at most `limit`.
std::size_t aligned(std::size_t limit) { return limit / kAlignment * kAlignment; }

GlTexture buffer_texture(GLenum format, GLuint buffer, std::string_view stage) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  GlTexture texture(name);
  glTextureBuffer(name, format, buffer);
  check_gl(stage);
  return texture;
}

GLint64 limit(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return value;
}

GLuint groups(std::size_t invocations) { return static_cast<GLuint>((invocations + kGroup - 1) / kGroup); }

void clear(const GlBuffer& buffer) {
  glClearNamedBufferData(buffer.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
}

void bind_storage(GLuint binding, const GlBuffer& buffer) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.name());
}

void set_uint(const GlProgram& program, const char* name, std::size_t value) {
  glProgramUniform1ui(program.name(), uniform_location(program, name), static_cast<GLuint>(value));
}

void set_int(const GlProgram& program, const char* name, int value) {
  glProgramUniform1i(program.name(), uniform_location(program, name), value);
}

GlProgram compute(std::vector<std::string_view> files, std::string_view defines = {}) {
  const std::array<ShaderStage, 1> stages{ShaderStage{GL_COMPUTE_SHADER, std::move(files)}};
  return make_program(stages, defines);
}

}  // namespace

/// As laid out in the shaders. scan.comp uses all; hivers.comp uses the first three and counts corrected samples in
/// contested_samples.
struct GpuClassifier::Counts {
  GLuint processed_faces, samples, contested_samples, contested_overflow, claims, large_faces;
};

GpuLimits gpu_limits() {
  return {static_cast<std::size_t>(limit(GL_MAX_TEXTURE_BUFFER_SIZE)),
          static_cast<std::size_t>(limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)),
          static_cast<int>(limit(GL_MAX_TEXTURE_SIZE))};
}

std::string GpuClassifier::obstacle(const Mesh& mesh, const GpuLimits& limits) {
  if (mesh.positions.size() * 3 > limits.texels || mesh.faces.size() * 3 > limits.texels)
    return "the mesh exceeds the texture buffers of this device";
  // The candidate list, one bit per face, must fit into one buffer. Everything else is split into dispatches, of which
  // the smallest projects an aligned number of vertices.
  if (mesh.faces.size() / 8 + 8 > limits.storage_bytes || kAlignment * kProjectedBytes > limits.storage_bytes)
    return "the mesh exceeds the storage buffers of this device";
  return {};
}

GpuClassifier::GpuClassifier(const Mesh& mesh, const IvmRenderer& renderer, const ClassifyOptions& options,
                             const GpuLimits& limits)
    : mesh_(mesh), renderer_(renderer), options_(options), limits_(limits) {
  project_program_ = compute({"raster.glsl", "project.comp"});
  counts_ = make_buffer(sizeof(Counts), nullptr, 0, "making the sample counts");
  const std::vector<std::string_view> shared{"raster.glsl", "coverage.glsl", "ivm.glsl",  "photo.glsl",
                                             "mesh.glsl",   "rows.glsl",     "codes.glsl"};
  const auto with = [&](std::string_view last) {
    std::vector<std::string_view> files = shared;
    files.push_back(last);
    return files;
  };
  const bool exact = options.correction == CoverageCorrection::exact;
  if (exact) {
    scan_program_ = compute(with("scan.comp"));
    large_program_ = compute(with("scan.comp"), "#define LARGE");
  } else {
    candidates_program_ = compute({"ivm.glsl", "photo.glsl", "candidate_faces.comp"});
    hivers_program_ = compute(with("hivers.comp"));
  }
  const std::size_t faces = mesh.faces.size(), vertices = mesh.positions.size();
  if (faces == 0 || vertices == 0) return;
  vertices_per_dispatch_ = std::min(kMostPerDispatch, aligned(limits.storage_bytes / kProjectedBytes));
  faces_per_dispatch_ = std::min(kMostPerDispatch, aligned(limits.storage_bytes / sizeof(GLuint)));
  projected_ = make_buffer(vertices * kProjectedBytes, nullptr, 0, "making the projected vertices");
  codes_ = make_buffer((faces + 3) / 4 * 4, nullptr, 0, "making the class codes");
  positions_texture_ = buffer_texture(GL_RG32UI, renderer.positions(), "reading the vertices in shaders");
  projected_texture_ = buffer_texture(GL_RG32UI, projected_.name(), "reading projected vertices in shaders");
  corners_texture_ = buffer_texture(GL_R32UI, renderer.faces(), "reading the faces in shaders");
  if (exact) {
    large_faces_ = make_buffer(std::min(faces, faces_per_dispatch_) * sizeof(GLuint), nullptr, 0,
                               "making the list of large faces");
    make_claims(std::min(limits.first_claims, limits.storage_bytes / sizeof(Claim)));
  } else {
    candidate_faces_ = make_buffer((faces + 31) / 32 * sizeof(GLuint), nullptr, 0, "making the candidate list");
  }
}

void GpuClassifier::make_claims(std::size_t capacity) {
  claims_ = make_buffer(capacity * sizeof(Claim), nullptr, 0, "making the list of claims");
  claim_capacity_ = capacity;
}

void GpuClassifier::upload_mask(const PhotoMask& mask) {
  if (mask_texture_.name() != 0 && mask_number_ == mask.number()) return;
  mask_number_ = mask.number();
  // A word of 64 pixels becomes two texels of 32 bits, the lower half first.
  static_assert(std::endian::native == std::endian::little);
  constexpr std::uint64_t kNothing = 0;
  const std::span<const std::uint64_t> words =
      mask.whole() ? std::span<const std::uint64_t>(&kNothing, 1) : mask.words();
  if (mask_words_ != words.size()) {
    mask_ = make_buffer(words.size_bytes(), nullptr, GL_DYNAMIC_STORAGE_BIT, "making the photo mask");
    mask_texture_ = buffer_texture(GL_R32UI, mask_.name(), "reading the photo mask in shaders");
    mask_words_ = words.size();
  }
  glNamedBufferSubData(mask_.name(), 0, static_cast<GLsizeiptr>(words.size_bytes()), words.data());
  check_gl("uploading the photo mask");
}

/// The renderer keeps only its last tile, so an item buffer of several tiles is uploaded again, cut into as few equal
/// tiles as the texture limit allows.
void GpuClassifier::upload_tiles(const PreparedView& view) {
  tile_width_ = tile_height_ = 0;
  if (renderer_.tiles(view.camera) == 1) return;
  const int width = view.camera.width, height = view.camera.height, most = limits_.texture_side;
  const int across = (width + most - 1) / most, down = (height + most - 1) / most;
  tile_width_ = (width + across - 1) / across;
  tile_height_ = (height + down - 1) / down;
  if (width != tiles_width_ || height != tiles_height_) {
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    tiles_texture_ = GlTexture(name);
    glTextureStorage3D(name, 1, GL_R32UI, tile_width_, tile_height_, across * down);
    set_nearest(tiles_texture_);
    tiles_width_ = width;
    tiles_height_ = height;
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, width);
  for (int tile = 0; tile < across * down; ++tile) {
    const int x0 = tile % across * tile_width_, y0 = tile / across * tile_height_;
    glTextureSubImage3D(tiles_texture_.name(), 0, 0, 0, tile, std::min(tile_width_, width - x0),
                        std::min(tile_height_, height - y0), 1, GL_RED_INTEGER, GL_UNSIGNED_INT, view.row(y0) + x0);
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  check_gl("uploading the tiles of the IVM");
}

void GpuClassifier::set_image(const GlProgram& program, const PreparedView& view) const {
  glProgramUniform2i(program.name(), uniform_location(program, "size"), view.camera.width, view.camera.height);
  glProgramUniform2i(program.name(), uniform_location(program, "tile_size"), tile_width_, tile_height_);
  set_int(program, "photo_stride", view.mask.whole() ? 0 : static_cast<int>(2 * view.mask.stride()));
  if (program.name() == candidates_program_.name()) return;
  glProgramUniform2d(program.name(), uniform_location(program, "projection_rounding"), view.rounding.u_per_z,
                     view.rounding.z_per_u);
}

void GpuClassifier::project(const Pose& pose, const Camera& camera) {
  set_camera(project_program_, camera, pose);
  glUseProgram(project_program_.name());
  glBindTextureUnit(kVertices, positions_texture_.name());
  for (std::size_t first = 0; first < mesh_.positions.size(); first += vertices_per_dispatch_) {
    const std::size_t count = std::min(vertices_per_dispatch_, mesh_.positions.size() - first);
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, projected_.name(), static_cast<GLintptr>(first * kProjectedBytes),
                      static_cast<GLsizeiptr>(count * kProjectedBytes));
    set_uint(project_program_, "first_vertex", first);
    set_uint(project_program_, "vertex_count", count);
    glDispatchCompute(groups(count), 1, 1);
  }
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  glBindTextureUnit(kVertices, projected_texture_.name());
  check_gl("projecting the vertices");
}

/// Uploads mask and tiles, binds the textures and projects the vertices.
void GpuClassifier::prepare_view(const PreparedView& view, const Pose& pose, VisibilityStatistics& statistics) {
  const Clock::time_point start = Clock::now();
  upload_mask(view.mask);
  upload_tiles(view);
  statistics.upload_s += seconds_since(start);
  glBindTextureUnit(kIvm, tile_width_ == 0 ? renderer_.ivm_texture() : 0);
  glBindTextureUnit(kMask, mask_texture_.name());
  glBindTextureUnit(kCorners, corners_texture_.name());
  glBindTextureUnit(kTiles, tile_width_ == 0 ? 0 : tiles_texture_.name());
  project(pose, view.camera);
}

void GpuClassifier::bind_codes(std::size_t first, std::size_t count) const {
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, codes_.name(), static_cast<GLintptr>(first),
                    static_cast<GLsizeiptr>((count + 3) / 4 * 4));
}

void GpuClassifier::dispatch_faces(const GlProgram& program, std::size_t first, std::size_t count) const {
  glUseProgram(program.name());
  set_uint(program, "first_face", first);
  set_uint(program, "face_count", count);
  glDispatchCompute(groups(count), 1, 1);
}

void GpuClassifier::read(const GlBuffer& from, std::size_t bytes, void* to) {
  const auto size = static_cast<GLsizeiptr>(bytes);
  if (!limits_.staged_reads) return glGetNamedBufferSubData(from.name(), 0, size, to);
  staging_.reserve(bytes);
  glCopyNamedBufferSubData(from.name(), staging_.name(), 0, 0, size);
  std::memcpy(to, staging_.wait(), bytes);
}

GpuClassifier::Counts GpuClassifier::read_counts() {
  Counts counts{};
  read(counts_, sizeof counts, &counts);
  return counts;
}

// --- off and paper

void GpuClassifier::find_candidates(const PreparedView& view) {
  clear(candidate_faces_);
  glUseProgram(candidates_program_.name());
  bind_storage(0, candidate_faces_);
  glDispatchCompute((static_cast<GLuint>(view.camera.width) + kTile - 1) / kTile,
                    (static_cast<GLuint>(view.camera.height) + kTile - 1) / kTile, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl("finding candidate faces");
}

GpuClassifier::Counts GpuClassifier::sample_faces(const PreparedView& view) {
  set_image(candidates_program_, view);
  set_image(hivers_program_, view);
  set_int(hivers_program_, "sampling", static_cast<int>(options_.sampling));
  set_int(hivers_program_, "correction", options_.correction == CoverageCorrection::off ? 0 : 1);
  find_candidates(view);
  clear(counts_);
  bind_storage(1, candidate_faces_);
  bind_storage(2, counts_);
  for (std::size_t first = 0; first < mesh_.faces.size(); first += faces_per_dispatch_) {
    const std::size_t count = std::min(faces_per_dispatch_, mesh_.faces.size() - first);
    bind_codes(first, count);
    dispatch_faces(hivers_program_, first, count);
  }
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glFinish();
  return read_counts();
}

// --- exact

void GpuClassifier::dispatch_contest(const PreparedView& view) {
  set_image(scan_program_, view);
  set_image(large_program_, view);
  clear(counts_);
  bind_storage(1, counts_);
  bind_storage(2, claims_);
  bind_storage(3, large_faces_);
  for (std::size_t first = 0; first < mesh_.faces.size(); first += faces_per_dispatch_) {
    const std::size_t count = std::min(faces_per_dispatch_, mesh_.faces.size() - first);
    bind_codes(first, count);
    if (first > 0) {
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      glClearNamedBufferSubData(counts_.name(), GL_R32UI, offsetof(Counts, large_faces), sizeof(GLuint), GL_RED_INTEGER,
                                GL_UNSIGNED_INT, nullptr);
    }
    dispatch_faces(scan_program_, first, count);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glUseProgram(large_program_.name());
    set_uint(large_program_, "first_face", first);
    glDispatchCompute(kLargeGroups, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glFinish();
}

GpuClassifier::Counts GpuClassifier::contest_faces(const PreparedView& view) {
  dispatch_contest(view);
  const Counts counts = read_counts();
  // A second scan makes the same number of claims, so it loses none once there is room for all of them. A quarter more is
  // allocated for later views.
  const std::size_t most = limits_.storage_bytes / sizeof(Claim);
  if (counts.claims <= claim_capacity_ || counts.claims > most) return counts;
  make_claims(std::min<std::size_t>(counts.claims + counts.claims / 4, most));
  dispatch_contest(view);
  return read_counts();
}

// --- both

void GpuClassifier::scan(const PreparedView& view, const Pose& pose, FaceScan& scan, VisibilityStatistics& statistics) {
  const bool exact = options_.correction == CoverageCorrection::exact;
  scan.start(mesh_.faces.size());
  if (faces_per_dispatch_ == 0 || (exact && !view.projected.moderate)) return;
  prepare_view(view, pose, statistics);
  const Clock::time_point start = Clock::now();
  const Counts counts = exact ? contest_faces(view) : sample_faces(view);
  statistics.shader_s += seconds_since(start);
  glUseProgram(0);
  check_gl("scanning faces");
  if (counts.claims > claim_capacity_) return;
  const Clock::time_point done = Clock::now();
  read(codes_, scan.codes.size(), scan.codes.data());
  scan.claims.resize(counts.claims);
  if (counts.claims > 0) read(claims_, counts.claims * sizeof(Claim), scan.claims.data());
  statistics.readback_s += seconds_since(done);
  check_gl("reading what the scan found");
  scan.counts.processed_faces = counts.processed_faces;
  scan.counts.samples = counts.samples;
  std::size_t& third = exact ? scan.counts.contested_samples : scan.counts.corrected_samples;
  third = (std::size_t{counts.contested_overflow} << 32) + counts.contested_samples;
}

}  // namespace gpvc::visibility
