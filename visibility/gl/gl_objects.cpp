#include "visibility/gl/gl_objects.h"

#include <algorithm>
#include <array>

namespace gpvc::visibility {
namespace {

const char* gl_error_name(GLenum code) {
  constexpr std::pair<GLenum, const char*> kNames[] = {
      {GL_INVALID_ENUM, "GL_INVALID_ENUM"},
      {GL_INVALID_VALUE, "GL_INVALID_VALUE"},
      {GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
      {GL_INVALID_FRAMEBUFFER_OPERATION, "GL_INVALID_FRAMEBUFFER_OPERATION"},
      {GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
      {GL_CONTEXT_LOST, "GL_CONTEXT_LOST"},
  };
  for (const auto& [known, name] : kNames)
    if (known == code) return name;
  return "an unknown OpenGL error";
}

std::string joined(const std::vector<std::string_view>& files) {
  std::string names;
  for (const std::string_view file : files) names += (names.empty() ? "" : " + ") + std::string(file);
  return names;
}

/// Throws the driver's log if the step that `status` names failed: `get` and `get_log` are those of shaders or of programs.
template <class Get, class GetLog>
void check_built(GLuint name, GLenum status, const Get& get, const GetLog& get_log, const std::string& failure) {
  GLint built = GL_FALSE, length = 0;
  get(name, status, &built);
  if (built != GL_FALSE) return;
  get(name, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  get_log(name, length, nullptr, log.data());
  throw GpuError("the driver cannot " + failure + ": " + log.c_str());
}

/// A shader object lives only until its program is linked.
using GlShader = GlObject<[](GLuint name) { glDeleteShader(name); }>;

GlShader compile(const ShaderStage& stage, std::string_view defines) {
  std::string text = "#version 450 core\n";
  text += defines;
  if (!defines.empty() && defines.back() != '\n') text += '\n';
  for (const std::string_view file : stage.files) {
    text += "#line 1\n";
    text += shader_source(file);
  }
  GlShader shader(glCreateShader(stage.type));
  const GLchar* data = text.c_str();
  const GLint length = static_cast<GLint>(text.size());
  glShaderSource(shader.name(), 1, &data, &length);
  glCompileShader(shader.name());
  check_built(shader.name(), GL_COMPILE_STATUS, glGetShaderiv, glGetShaderInfoLog,
              "compile shader " + joined(stage.files));
  return shader;
}

}  // namespace

void check_gl(std::string_view stage) {
  const GLenum code = glGetError();
  if (code == GL_NO_ERROR) return;
  // Several errors may be pending; a lost context repeats its error forever.
  for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; ++i) continue;
  throw GpuError(std::string(stage) + ": " + gl_error_name(code));
}

GlBuffer make_buffer(std::size_t bytes, const void* data, GLbitfield flags, std::string_view stage) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  GlBuffer buffer(name);
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), data, flags);
  check_gl(std::string(stage) + ": a buffer of " + std::to_string(bytes) + " bytes");
  return buffer;
}

void GlReadBuffer::reserve(std::size_t bytes) {
  if (bytes <= bytes_) return;
  *this = {};
  constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  buffer_ = make_buffer(bytes, nullptr, kAccess | GL_CLIENT_STORAGE_BIT, "creating the read-back buffer");
  mapped_ =
      static_cast<const std::byte*>(glMapNamedBufferRange(buffer_.name(), 0, static_cast<GLsizeiptr>(bytes), kAccess));
  check_gl("mapping the read-back buffer");
  if (mapped_ == nullptr) throw GpuError("the driver cannot map a buffer of " + std::to_string(bytes) + " bytes");
  bytes_ = bytes;
}

const std::byte* GlReadBuffer::wait() const {
  glFinish();
  return mapped_;
}

GlTexture make_texture_2d(GLenum internal_format, int width, int height, std::string_view stage) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  GlTexture texture(name);
  glTextureStorage2D(name, 1, internal_format, width, height);
  check_gl(std::string(stage) + ": a texture of " + std::to_string(width) + " x " + std::to_string(height));
  return texture;
}

GlFramebuffer make_framebuffer(GLuint color_texture, GLuint depth_texture, std::string_view stage) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  GlFramebuffer framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, color_texture, 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth_texture, 0);
  check_gl(stage);
  if (glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GpuError(std::string(stage) + ": the driver reports an incomplete framebuffer");
  return framebuffer;
}

GlVertexArray make_vertex_array() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  return GlVertexArray(name);
}

GlProgram make_program(std::span<const ShaderStage> stages, std::string_view defines) {
  GlProgram program(glCreateProgram());
  std::string names;
  for (const ShaderStage& stage : stages) {
    const GlShader shader = compile(stage, defines);
    glAttachShader(program.name(), shader.name());
    names += (names.empty() ? "" : ", ") + joined(stage.files);
  }
  glLinkProgram(program.name());
  check_built(program.name(), GL_LINK_STATUS, glGetProgramiv, glGetProgramInfoLog, "link " + names);
  return program;
}

void set_camera(const GlProgram& program, const Camera& camera, const Pose& pose) {
  std::array<double, 12> pose_values{};
  std::copy(pose.rotation.begin(), pose.rotation.end(), pose_values.begin());
  pose_values[9] = pose.centre.x;
  pose_values[10] = pose.centre.y;
  pose_values[11] = pose.centre.z;
  const std::array<double, 4> intrinsics{camera.fx, camera.fy, camera.cx, camera.cy};
  glProgramUniform1dv(program.name(), uniform_location(program, "pose"), 12, pose_values.data());
  glProgramUniform1dv(program.name(), uniform_location(program, "intrinsics"), 4, intrinsics.data());
}

GLint uniform_location(const GlProgram& program, const char* name) {
  const GLint location = glGetUniformLocation(program.name(), name);
  if (location < 0) throw GpuError("the shader program has no active uniform " + std::string(name));
  return location;
}

}  // namespace gpvc::visibility
