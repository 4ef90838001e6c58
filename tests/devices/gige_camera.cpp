// gige_camera ADDRESS SERIAL RECORDING [LOST_RATIO]: a GigE Vision camera on that address of this host, made of the
// fake one that Aravis brings, whose pictures are the frames of a recording, in whichever format it is set to. Ends
// when it is killed. LOST_RATIO of its packets, 0 to 1, never leave.
#include <arv.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "capture/aravis_formats.h"
#include "capture/recording.h"
#include "core/convert.h"

namespace {

/// The frames of a recording in the formats that were asked for so far. Of the camera's thread alone.
struct Pictures {
  std::vector<chequer::Image> originals;
  std::map<ArvPixelFormat, std::vector<chequer::Image>> converted;
  std::size_t next = 0;
};

const std::vector<chequer::Image>& InFormat(Pictures& pictures, ArvPixelFormat code, chequer::PixelFormat format) {
  std::vector<chequer::Image>& images = pictures.converted[code];
  if (images.empty())
    for (const chequer::Image& original : pictures.originals)
      images.push_back(chequer::ConvertImage(original.view(), format));
  return images;
}

/// What Aravis calls for each frame. The buffer is as large as a frame of its size and format; what is beyond the
/// picture stays as it is.
void Fill(ArvBuffer* buffer, void* data, guint32, guint32, ArvPixelFormat code) {
  Pictures& pictures = *static_cast<Pictures*>(data);
  const auto format = chequer::PixelFormatOfGenicam(code);
  if (!format) return;
  const std::vector<chequer::Image>& images = InFormat(pictures, code, *format);
  const chequer::ImageView image = images[pictures.next++ % images.size()].view();
  const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
  const auto row_bytes = static_cast<std::size_t>(chequer::PlaneShapes(*format, width, height).front().row_bytes);
  const auto picture_bytes =
      static_cast<std::size_t>(chequer::PlaneShapes(*format, image.width(), image.height()).front().row_bytes);
  std::size_t size = 0;  // not told here: nothing has been received
  auto* to = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
  for (int y = 0; y < std::min(height, image.height()); ++y)
    std::memcpy(to + row_bytes * static_cast<std::size_t>(y), image.row(y), std::min(row_bytes, picture_bytes));
}

int Run(std::span<char*> arguments) {
  if (arguments.size() < 4) {
    std::fprintf(stderr, "usage: gige_camera ADDRESS SERIAL RECORDING [LOST_RATIO]\n");
    return 2;
  }
  Pictures pictures;
  const chequer::Recording recording = chequer::OpenRecording(arguments[3]);
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    pictures.originals.push_back(chequer::LoadFrame(recording, i));
  ArvGvFakeCamera* camera = arv_gv_fake_camera_new(arguments[1], arguments[2]);
  if (camera == nullptr || arv_gv_fake_camera_is_running(camera) == 0) {
    std::fprintf(stderr, "gige_camera: cannot start on %s\n", arguments[1]);
    return 1;
  }
  if (arguments.size() > 4) g_object_set(camera, "gvsp-lost-ratio", std::atof(arguments[4]), nullptr);
  arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(camera), Fill, &pictures);
  std::printf("camera %s is up\n", arguments[2]);
  std::fflush(stdout);
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  int signal = 0;
  sigwait(&ends, &signal);
  g_object_unref(camera);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Before any thread of Aravis starts, so that it is the same in all.
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  sigprocmask(SIG_BLOCK, &ends, nullptr);
  try {
    return Run({argv, static_cast<std::size_t>(argc)});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gige_camera: %s\n", error.what());
    return 1;
  }
}
