// libjpeg's errors, which end what is under way by a jump. No object with a destructor may live where one can come from.
#pragma once

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>

#include <jpeglib.h>

namespace gpvc::io {

struct JpegErrors {
  jpeg_error_mgr manager{};
  std::jmp_buf failed{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

/// libjpeg tells that `state`, whose client_data are a JpegErrors, cannot go on.
[[noreturn]] inline void leave(j_common_ptr state) {
  auto* errors = static_cast<JpegErrors*>(state->client_data);
  state->err->format_message(state, errors->message.data());
  std::longjmp(errors->failed, 1);
}

/// To be called before `state` is created, which keeps what it is given here.
template <typename State>
void take_errors(State& state, JpegErrors& errors) {
  state.err = jpeg_std_error(&errors.manager);
  state.client_data = &errors;
  errors.manager.error_exit = leave;
  errors.manager.output_message = [](j_common_ptr) {};
}

/// False: an error ended `steps`, and `errors` tell why.
template <typename Steps>
[[gnu::noinline]] bool run(JpegErrors& errors, const Steps& steps) {
  if (setjmp(errors.failed) != 0) return false;
  steps();
  return true;
}

}  // namespace gpvc::io
