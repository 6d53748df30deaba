#include "visibility/classify_gl.h"

#include <algorithm>
#include <array>

#include "visibility/raster.h"

namespace gpvc {
namespace {

constexpr GLuint kGroup = 64;  // local_size_x of hivers.comp
constexpr GLuint kTile = 16;   // local_size of candidate_faces.comp

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

}  // namespace

std::string GpuClassifier::obstacle(const Mesh& mesh) {
  const auto texels = static_cast<std::size_t>(limit(GL_MAX_TEXTURE_BUFFER_SIZE));
  const auto block = static_cast<std::size_t>(limit(GL_MAX_SHADER_STORAGE_BLOCK_SIZE));
  if (mesh.positions.size() * 3 > texels || mesh.faces.size() * 3 > texels)
    return "the mesh exceeds the texture buffers of this device";
  if (mesh.faces.size() / 8 + 8 > block) return "the mesh exceeds the storage buffers of this device";
  return {};
}

GpuClassifier::GpuClassifier(const Mesh& mesh, const IvmRenderer& renderer, const VisibilityOptions& options)
    : mesh_(mesh), renderer_(renderer), options_(options) {
  const std::array<ShaderStage, 1> candidates{
      ShaderStage{GL_COMPUTE_SHADER, {"photo.glsl", "candidate_faces.comp"}}};
  const std::array<ShaderStage, 1> hivers{
      ShaderStage{GL_COMPUTE_SHADER, {"raster.glsl", "coverage.glsl", "photo.glsl", "hivers.comp"}}};
  candidates_program_ = make_program(candidates);
  hivers_program_ = make_program(hivers);
  counts_ = make_buffer(3 * sizeof(GLuint), nullptr, 0, "making the sample counts");
  if (mesh.faces.empty()) return;
  positions_ = buffer_texture(GL_RG32UI, renderer.positions(), "reading the vertices in shaders");
  corners_ = buffer_texture(GL_R32UI, renderer.faces(), "reading the faces in shaders");
  candidate_faces_ =
      make_buffer((mesh.faces.size() + 31) / 32 * sizeof(GLuint), nullptr, 0, "making the candidate list");
  // The codes are written in chunks, so that their buffer stays below the storage limit and dispatches below
  // the limit on work groups.
  faces_per_dispatch_ = std::min<std::size_t>(mesh.faces.size(), std::size_t{1} << 21);
  codes_ = make_buffer(faces_per_dispatch_ * sizeof(GLuint), nullptr, 0, "making the class codes");
}

void GpuClassifier::upload_mask(const PhotoMask& mask) {
  if (photo_mask_.name() != 0 && mask_number_ == mask.number()) return;
  mask_number_ = mask.number();
  const std::span<const std::uint64_t> words = mask.words();
  if (words.empty()) {
    photo_mask_ = make_texture_2d(GL_R32UI, 1, 1, 1, "making the photo mask");
    set_nearest(photo_mask_);
    return;
  }
  const auto width = static_cast<GLsizei>(mask.stride() * 2);
  const auto height = static_cast<GLsizei>(words.size() / mask.stride());
  std::vector<GLuint> halves;
  halves.reserve(words.size() * 2);
  for (const std::uint64_t word : words) {
    halves.push_back(static_cast<GLuint>(word));
    halves.push_back(static_cast<GLuint>(word >> 32));
  }
  photo_mask_ = make_texture_2d(GL_R32UI, width, height, 1, "making the photo mask");
  set_nearest(photo_mask_);
  glTextureSubImage2D(photo_mask_.name(), 0, 0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_INT,
                      halves.data());
  check_gl("uploading the photo mask");
}

void GpuClassifier::find_candidates(const Camera& camera) {
  const GLuint zero = 0;
  glClearNamedBufferData(candidate_faces_.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
  glUseProgram(candidates_program_.name());
  glUniform2i(uniform_location(candidates_program_, "size"), camera.width, camera.height);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, candidate_faces_.name());
  glDispatchCompute((static_cast<GLuint>(camera.width) + kTile - 1) / kTile,
                    (static_cast<GLuint>(camera.height) + kTile - 1) / kTile, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  check_gl("finding candidate faces");
}

void GpuClassifier::set_view(const Camera& camera, const Pose& pose) {
  std::array<double, 12> pose_values{};
  std::copy(pose.rotation.begin(), pose.rotation.end(), pose_values.begin());
  pose_values[9] = pose.centre.x;
  pose_values[10] = pose.centre.y;
  pose_values[11] = pose.centre.z;
  const std::array<double, 4> intrinsics{camera.fx, camera.fy, camera.cx, camera.cy};
  glUseProgram(hivers_program_.name());
  glUniform1dv(uniform_location(hivers_program_, "pose"), 12, pose_values.data());
  glUniform1dv(uniform_location(hivers_program_, "intrinsics"), 4, intrinsics.data());
  glUniform2i(uniform_location(hivers_program_, "size"), camera.width, camera.height);
  const ProjectionRounding rounding = projection_rounding(camera);
  glUniform2d(uniform_location(hivers_program_, "projection_rounding"), rounding.u_per_z, rounding.z_per_u);
  glUniform1i(uniform_location(hivers_program_, "sampling"), static_cast<GLint>(options_.sampling));
  glUniform1i(uniform_location(hivers_program_, "correction"),
              options_.correction == CoverageCorrection::off ? 0 : 1);
}

void GpuClassifier::classify(const Camera& camera, const Pose& pose, const PhotoMask& mask,
                             std::vector<FaceCode>& codes, VisibilityStatistics& statistics) {
  codes.resize(mesh_.faces.size());
  if (mesh_.faces.empty()) return;
  upload_mask(mask);
  const std::array<GLuint, 4> textures{renderer_.ivm_texture(), photo_mask_.name(), positions_.name(),
                                       corners_.name()};
  glBindTextures(0, static_cast<GLsizei>(textures.size()), textures.data());
  const GLint whole = mask.whole() ? 1 : 0;
  for (const GlProgram* program : {&candidates_program_, &hivers_program_})
    glProgramUniform1i(program->name(), uniform_location(*program, "photo_is_whole"), whole);
  find_candidates(camera);
  set_view(camera, pose);
  const GLuint zero = 0;
  glClearNamedBufferData(counts_.name(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, codes_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, counts_.name());
  for (std::size_t first = 0; first < codes.size(); first += faces_per_dispatch_) {
    const std::size_t count = std::min(faces_per_dispatch_, codes.size() - first);
    glUniform1ui(uniform_location(hivers_program_, "first_face"), static_cast<GLuint>(first));
    glUniform1ui(uniform_location(hivers_program_, "face_count"), static_cast<GLuint>(count));
    glDispatchCompute((static_cast<GLuint>(count) + kGroup - 1) / kGroup, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(codes_.name(), 0, static_cast<GLsizeiptr>(count * sizeof(GLuint)),
                            codes.data() + first);
  }
  std::array<GLuint, 3> counts{};
  glGetNamedBufferSubData(counts_.name(), 0, sizeof counts, counts.data());
  statistics.processed_faces += counts[0];
  statistics.samples += counts[1];
  statistics.corrected_samples += counts[2];
  glUseProgram(0);
  check_gl("classifying faces");
}

}  // namespace gpvc
