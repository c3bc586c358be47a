// A rig of bodies in the number type of the computation, and the room its pieces are expanded in.
#pragma once

#include "stickslip/bodies/dense.hpp"
#include "stickslip/bodies/parts.hpp"

namespace stickslip::inline STICKSLIP_ISA {

template <class T>
struct BodiesSystem {
  const Bodies* b = nullptr;
  BodiesLayout at{};
  int n = 0, contacts = 0, speeds = 0, pushes = 0, states = 0, columns = 0;
  T* values = nullptr;
  T* inverse = nullptr;       // of M
  T* reach = nullptr;         // M^-1 d_j (contacts x n)
  Real<T>* weight = nullptr;  // root of the inertia of each coordinate
  T* free = nullptr;          // q'' of the free rig by (q, q', 1, x, V, -T, F): n x columns
  T* projected = nullptr;     // the same with what sticks held
  T* held = nullptr;          // friction of what sticks by the same (contacts x columns)
  T* yields = nullptr;        // M^-1 D' G^-1: what an acceleration of the stuck adds (n x contacts)
  T *compliance = nullptr, *stiff = nullptr, *room = nullptr;  // G = D M^-1 D', its inverse
  int* stuck = nullptr;
  int stuck_count = 0;
  int surface_order = max_order;  // of surfaces where a formula goes over continuously
  Real<T> rate{}, frequency{};    // bounds on the eigenvalues of the present modes, and of the springs
  bool pulled = false;            // some force follows a prescribed motion
  Contact<T>* contact = nullptr;
  Rail<T>* rail = nullptr;
  Push<T>* push = nullptr;
  // the series of a piece
  T *q = nullptr, *v = nullptr, *z = nullptr, *x = nullptr, *V = nullptr;
  T *u = nullptr, *force = nullptr, *friction = nullptr, *margin = nullptr, *dwell = nullptr, *time = nullptr;
  const T** states_of = nullptr;
  int ids = 0;  // of switching functions: 2 a contact, one a node of every tape

  T* D(int j) const { return values + at.D + j * n; }
  T* G(int e) const { return values + at.G + e * n; }
  static T* row(T* all, int i) { return all + i * series_size; }  // NOLINT(clang-analyzer-core.NullPointerArithm)

  void place(Arena& arena, const Bodies& bodies, const double* numbers) {
    b = &bodies;
    at = layout_of(bodies);
    n = bodies.n, contacts = bodies.contacts, speeds = bodies.speeds, pushes = bodies.pushes, states = bodies.states;
    columns = 2 * n + 1 + 2 * speeds + contacts + pushes;
    values = arena.take<T>(at.size);
    inverse = arena.take<T>(n * n);
    reach = arena.take<T>(contacts * n);
    weight = arena.take<Real<T>>(n);
    free = arena.take<T>(n * columns);
    projected = arena.take<T>(n * columns);
    held = arena.take<T>(contacts * columns);
    yields = arena.take<T>(n * contacts);
    compliance = arena.take<T>(contacts * contacts);
    stiff = arena.take<T>(contacts * contacts);
    room = arena.take<T>(n * n + contacts * columns);
    stuck = arena.take<int>(contacts);
    for (T** one : {&q, &v}) *one = arena.take<T>(n * series_size);
    z = arena.take<T>(states * series_size);
    for (T** one : {&x, &V}) *one = arena.take<T>(speeds * series_size);
    for (T** one : {&u, &friction, &dwell}) *one = arena.take<T>(contacts * series_size);
    force = arena.take<T>((contacts + pushes) * series_size);  // of contacts, then of pushes
    margin = arena.take<T>(2 * contacts * series_size);
    time = arena.take<T>(series_size);
    states_of = arena.take<const T*>(states);
    contact = arena.take<Contact<T>>(contacts);
    rail = arena.take<Rail<T>>(speeds);
    push = arena.take<Push<T>>(pushes);
    place_tapes(arena, numbers + at.parameters);
  }

 private:
  void place_tapes(Arena& arena, const double* parameters) {
    const bool real = arena.base != nullptr;
    int first = 0;
    ids = 2 * contacts;
    Contact<T> scratch{};
    for (int j = 0; j < contacts; ++j) {
      Contact<T>& one = real ? contact[j] : scratch;
      one = Contact<T>{};
      const LawTape& law = b->laws[j];
      one.states = law.states;
      one.first_state = first;
      one.speed = b->contact_speed[j];
      for (int s = 0; s < 2; ++s) {
        one.compliant[s] = law.branch[s].limit < 0;
        one.tape[s].place(arena, law.branch[s], parameters);
        one.tape[s].reads = {
            values + at.parameters, row(u, j), time, row(dwell, j), states_of + first, 0.0, false, q, v, x, V};
        if (real) set_keys(one.tape[s], j);
        one.tape[s].first_id = ids;
        ids += law.branch[s].count;
      }
      if (real)
        for (int i = 0; i < law.states; ++i) states_of[first + i] = row(z, first + i);
      first += law.states;
    }
    Rail<T> line{};
    for (int s = 0; s < speeds; ++s) {
      Rail<T>& one = real ? rail[s] : line;
      one = Rail<T>{};
      const SpeedTape& speed = b->speed[s];
      Tape<T>* pieces = arena.take<Tape<T>>(speed.count);
      one.piece = pieces;
      Tape<T> piece{};
      for (int i = 0; i < speed.count; ++i) {
        Tape<T>& tape = real ? pieces[i] : piece;
        tape = Tape<T>{};
        tape.place(arena, speed.pieces[i], parameters);
        tape.reads = {values + at.parameters, time, time, time, nullptr, 1.0, true};
      }
    }
    place_pushes(arena, parameters, first);
  }
  void place_pushes(Arena& arena, const double* parameters, int first) {
    const bool real = arena.base != nullptr;
    Push<T> scratch{};
    for (int e = 0; e < pushes; ++e) {
      Push<T>& one = real ? push[e] : scratch;
      one = Push<T>{};
      const PushTape& given = b->push[e];
      one.states = given.states;
      one.first_state = first;
      one.tape.place(arena, given.formulas, parameters);
      one.tape.reads = {values + at.parameters, time, time, time, states_of + first, 0.0, false, q, v, x, V};
      if (real) set_keys(one.tape, contacts + e);
      one.tape.first_id = ids;
      ids += given.formulas.count;
      if (real)
        for (int i = 0; i < given.states; ++i) states_of[first + i] = row(z, first + i);
      first += given.states;
    }
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
