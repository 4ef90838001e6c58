#include "daemon/mailbox.h"

#include <sys/eventfd.h>

#include <cerrno>
#include <system_error>

namespace chequer {

Mailbox::Mailbox() : wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_.valid()) throw std::system_error(errno, std::generic_category(), "eventfd");
}

template <typename Change>
void Mailbox::Update(Change&& change) {
  {
    const std::lock_guard lock(mutex_);
    change();
  }
  eventfd_write(wake_.get(), 1);
}

void Mailbox::Put(const StatusMessage& status) {
  Update([&] { mail_.status = status; });
}

void Mailbox::PutReady() {
  Update([&] { mail_.ready = true; });
}

void Mailbox::PutFinished() {
  Update([&] { mail_.finished = true; });
}

Mailbox::Mail Mailbox::Take() {
  eventfd_t ignored = 0;
  eventfd_read(wake_.get(), &ignored);
  const std::lock_guard lock(mutex_);
  Mail taken{std::exchange(mail_.status, std::nullopt), mail_.ready, std::exchange(mail_.finished, false)};
  return taken;
}

}  // namespace chequer
