// See tasks.hpp.
#include "solver/linear/petsc/tasks.hpp"

#include "solver/linear/petsc/session.hpp"

#include <algorithm>
#include <new>

namespace hvi::petsc_module {
namespace {

constexpr int tag = 1;
/// MPI counts in int.
constexpr std::size_t most_at_once = std::size_t{1} << 30;

void send(int to, const char* bytes, std::size_t size) {
  unsigned long long length = size;
  MPI_Send(&length, 1, MPI_UNSIGNED_LONG_LONG, to, tag, world());
  for (std::size_t done = 0; done < size; done += most_at_once)
    MPI_Send(bytes + done, static_cast<int>(std::min(most_at_once, size - done)), MPI_BYTE, to, tag,
             world());
}

std::string receive(int from) {
  unsigned long long length = 0;
  MPI_Recv(&length, 1, MPI_UNSIGNED_LONG_LONG, from, tag, world(), MPI_STATUS_IGNORE);
  std::string out(static_cast<std::size_t>(length), '\0');
  for (std::size_t done = 0; done < out.size(); done += most_at_once)
    MPI_Recv(out.data() + done, static_cast<int>(std::min(most_at_once, out.size() - done)),
             MPI_BYTE, from, tag, world(), MPI_STATUS_IGNORE);
  return out;
}

} // namespace

void hand_out(const HviPetscBytes* messages) {
  for (int p = 1; p < processes(); ++p) send(p, messages[p - 1].bytes, messages[p - 1].size);
}

std::vector<std::string> take_in() {
  std::vector<std::string> out;
  for (int p = 1; p < processes(); ++p) out.push_back(receive(p));
  return out;
}

void answer(const HviPetscHelper& helper, int errand) {
  const std::string message = receive(0);
  const HviPetscBytes said =
      helper.answer(helper.context, errand, {message.data(), message.size()});
  if (said.bytes == nullptr) throw std::bad_alloc();
  send(0, said.bytes, said.size);
}

} // namespace hvi::petsc_module
