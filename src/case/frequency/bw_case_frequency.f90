module bw_case_frequency
  !! The frequency response of a case. Undamped or with Rayleigh damping it is the exact solution of the boundary value
  !! problem (bw_forced_beam). With one damping ratio for all modes, with tension or taper, or on a free hub it is a
  !! modal sum with a correction for omitted modes (bw_modal_response).
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_modes, only: case_mode_cache, extend_source, find_sources
  use bw_case_result, only: answer_type, case_done, case_not_converged
  use bw_constants, only: two_pi
  use bw_damping, only: law_of
  use bw_double_double, only: dd
  use bw_forced_beam, only: forced_beam
  use bw_junction_waves, only: find_scattered
  use bw_kinds, only: dp
  use bw_missing, only: missing, scaled
  use bw_modal_response, only: chosen, modal_response, modal_terms, terms_of
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: joint_position, junctions_of, piece_beam
  use bw_piece_source, only: source_of_pieces
  use bw_response_extremes, only: find_extremes, harmonic_response
  use bw_scene, only: answers_by_modes, scene_type, varies_along_pieces
  use bw_scene_pieces, only: in_uniform_parts, pieces_of, struck_beam, varying_of
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: find_frequency_response

  integer, parameter, public :: modes_of_answer = 64 !! fewest modes of a modal sum
  integer, parameter :: most_modes = 512
  real(dp), parameter :: beyond = 4.0_dp             !! aim for modes up to so many times the highest frequency
  integer, parameter :: at_once = 256                !! frequencies between two calls of the monitor

  type, extends(harmonic_response) :: boundary_response
    !! Solves the boundary value problem.
    type(forced_beam) :: forced
    real(dp) :: mass = 0.0_dp, stiffness = 0.0_dp    !! Rayleigh damping
  contains
    procedure :: at => solve_boundary
  end type boundary_response

contains

  subroutine find_frequency_response(scene, units, junctions, with_extremes, monitor, cache, answer, notes, status)
    !! Find the response of all points at all frequencies, SI.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: junctions                 !! most junctions of the beam; 0: not requested
    logical, intent(in) :: with_extremes             !! find resonances and antiresonances
    class(monitor_type), intent(inout) :: monitor    !! the answer is invalid if it requests a stop
    type(case_mode_cache), intent(inout), target :: cache
    type(answer_type), allocatable, intent(out) :: answer
    type(string), allocatable, intent(inout) :: notes(:)
    integer, intent(inout) :: status                 !! of the case
    type(struck_beam) :: pieces
    real(dp), allocatable :: omega(:)                ! in h/l²
    complex(dp), allocatable :: factor(:)
    allocate (answer)
    pieces = pieces_of(scene, units, allocated(scene%capture))
    omega = two_pi*scene%frequency_response%frequency*units%time%hi
    if (junctions > 0) call scatter(pieces%beam, omega, junctions, monitor, answer)
    if (monitor%stop_requested()) return
    call in_uniform_parts(pieces)                    ! replaces taper by steps
    associate (asked => scene%frequency_response)
      allocate (answer%value(size(omega), size(asked%points)))
      factor = factors_of(asked%quantity, two_pi*asked%frequency, units%time%hi**2/units%mass)
    end associate
    if (answers_by_modes(scene)) then
      call by_modes(scene, units, pieces, omega, factor, with_extremes, monitor, cache, answer)
    else
      call by_boundary(scene, units, pieces%beam, omega, factor, with_extremes, monitor, cache, answer)
    end if
    if (monitor%stop_requested()) return
    call keep_numbers(answer%value)
    if (allocated(answer%error)) call judge_error(answer, notes, status)
  end subroutine find_frequency_response

  subroutine scatter(beam, omega, junctions, monitor, answer)
    !! Find the transmission and reflection coefficients, in power, of bodies and steps.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: omega(:)                 !! in h/l²
    integer, intent(in) :: junctions                 !! upper limit
    class(monitor_type), intent(inout) :: monitor    !! the shares are invalid if it requests a stop
    type(answer_type), intent(inout) :: answer
    type(dd) :: place
    integer, allocatable :: joints(:)
    integer :: i, j
    joints = junctions_of(beam)
    allocate (answer%junction(junctions), source=missing)
    allocate (answer%transmitted(size(omega), junctions), answer%reflected(size(omega), junctions), source=missing)
    do i = 1, size(joints)
      place = joint_position(beam, joints(i))
      answer%junction(i) = place%hi
      do j = 1, size(omega)
        if (mod(j, at_once) == 0) then
          if (monitor%stop_requested()) return
        end if
        call find_scattered(beam, joints(i), omega(j)**2, answer%transmitted(j, i), answer%reflected(j, i))
      end do
    end do
    where (.not. ieee_is_finite(answer%transmitted + answer%reflected))
      answer%transmitted = missing
      answer%reflected = missing
    end where
  end subroutine scatter

  subroutine by_boundary(scene, units, beam, omega, factor, with_extremes, monitor, cache, answer)
    !! Solve the boundary value problem at all frequencies.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(piece_beam), intent(in) :: beam             !! in uniform parts
    real(dp), intent(in) :: omega(:)
    complex(dp), intent(in) :: factor(:)             !! to SI units, (frequencies)
    logical, intent(in) :: with_extremes
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(answer_type), intent(inout) :: answer
    type(boundary_response) :: response
    type(modal_terms) :: modes
    class(mode_set), allocatable :: set
    integer :: j
    call response%forced%place(beam, scene%frequency_response%position, scene%frequency_response%points)
    if (allocated(scene%damping)) then
      associate (law => law_of(scene%damping, units))
        response%mass = law%mass
        response%stiffness = law%stiffness
      end associate
    end if
    do j = 1, size(omega)
      if (mod(j, at_once) == 0) then
        call monitor%advance(real(j, dp)/size(omega))
        if (monitor%stop_requested()) return
      end if
      call response%at(omega(j), 0, answer%value(j, :))
      answer%value(j, :) = factor(j)*answer%value(j, :)
    end do
    if (.not. with_extremes) return
    call find_enough(scene, units, omega(size(omega)), monitor, cache, set)
    if (monitor%stop_requested() .or. .not. set%resolved) return
    modes = terms_of(scene, set)
    call look_for_extremes(scene, units, response, modes, omega, monitor, answer)
  end subroutine by_boundary

  subroutine solve_boundary(self, omega, point, value)
    class(boundary_response), intent(inout) :: self
    real(dp), intent(in) :: omega
    integer, intent(in) :: point
    complex(dp), intent(out) :: value(:)
    complex(dp) :: all(self%forced%points())
    call self%forced%respond(cmplx(omega**2, -omega*self%mass, dp), cmplx(0.0_dp, omega*self%stiffness, dp), all)
    value = chosen(all, point)
  end subroutine solve_boundary

  subroutine look_for_extremes(scene, units, response, modes, omega, monitor, answer)
    !! Find resonances and antiresonances, SI.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(harmonic_response), intent(inout) :: response
    type(modal_terms), intent(in) :: modes
    real(dp), intent(in) :: omega(:)
    class(monitor_type), intent(inout) :: monitor
    type(answer_type), intent(inout) :: answer
    integer :: order
    order = 0
    if (scene%frequency_response%quantity == 'velocity') order = 1
    if (scene%frequency_response%quantity == 'acceleration') order = 2
    call find_extremes(response, modes%square, modes%damping, order, [omega(1), omega(size(omega))], &
                       size(answer%value, 2), monitor, answer%extremes)
    associate (extremes => answer%extremes)
      extremes%omega = extremes%omega/units%time%hi
      extremes%amplitude = scaled(extremes%amplitude, units%time%hi**(2 - order)/units%mass)
    end associate
  end subroutine look_for_extremes

  subroutine by_modes(scene, units, pieces, omega, factor, with_extremes, monitor, cache, answer)
    !! Sum all modes that are found, and half of them, whose difference estimates the error.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(struck_beam), intent(in) :: pieces
    real(dp), intent(in) :: omega(:)
    complex(dp), intent(in) :: factor(:)             !! to SI units, (frequencies)
    logical, intent(in) :: with_extremes
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(answer_type), intent(inout) :: answer
    type(modal_response) :: response
    class(mode_source), allocatable :: uniform
    class(mode_set), allocatable :: set
    complex(dp) :: half(size(answer%value, 2))
    integer :: j, n
    call find_enough(scene, units, beyond*omega(size(omega)), monitor, cache, set)
    if (monitor%stop_requested()) return
    allocate (answer%error(size(half)), source=missing)
    answer%value = cmplx(missing, missing, dp)
    if (.not. set%resolved) return
    call response%forced%place(pieces%beam, scene%frequency_response%position, scene%frequency_response%points)
    response%n = set%count
    response%own = terms_of(scene, set)
    response%plain = response%own
    if (allocated(scene%hub)) then
      call response%let_grow(set, varying_of(scene, units, pieces_of(scene, units, allocated(scene%capture))), &
                             scene%frequency_response%position, scene%frequency_response%points, omega(size(omega)))
    else if (varies_along_pieces(scene)) then
      allocate (uniform, source=source_of_pieces(pieces))
      call uniform%find(first_numbers(response%n), set, monitor=monitor)
      if (monitor%stop_requested() .or. .not. set%resolved) return
      response%plain = terms_of(scene, set)
    end if
    n = response%n
    answer%error = 0.0_dp
    do j = 1, size(omega)
      if (mod(j, at_once) == 0) then
        call monitor%advance(real(j, dp)/size(omega))
        if (monitor%stop_requested()) return
      end if
      call response%at(omega(j), 0, answer%value(j, :))
      response%n = n/2
      call response%at(omega(j), 0, half)
      response%n = n
      answer%value(j, :) = factor(j)*answer%value(j, :)
      answer%error = max(answer%error, abs(answer%value(j, :) - factor(j)*half) + abs(factor(j))*response%rounding_at(omega(j)))
    end do
    if (with_extremes) call look_for_extremes(scene, units, response, response%own, omega, monitor, answer)
  end subroutine by_modes

  subroutine find_enough(scene, units, omega, monitor, cache, set)
    !! Find modes up to a frequency, as far as there are any.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: omega                    !! in h/l², to be exceeded
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    class(mode_set), allocatable, intent(out) :: set
    type(case_modes) :: modes
    integer :: n
    logical :: extended
    call find_sources(scene, units, monitor, modes, cache)
    if (monitor%stop_requested()) return
    associate (source => modes%configuration(modes%moving)%source)
      n = modes_of_answer
      do
        if (source%highest < n) then
          call extend_source(scene, units, modes%moving, monitor, source, extended, cache)
          if (monitor%stop_requested()) return
          if (extended) cycle
        end if
        n = min(n, source%highest)
        call source%find(first_numbers(n), set, monitor=monitor)
        if (monitor%stop_requested() .or. .not. set%resolved) return
        if (set%beta_squared(n)%hi > omega**2 .or. n == min(source%highest, most_modes)) return
        n = min(2*n, most_modes)
      end do
    end associate
  end subroutine find_enough

  pure function factors_of(quantity, omega, flexibility) result(factor)
    !! Return the factors from displacement in l over force in EI/l² to SI units, (frequencies).
    character(*), intent(in) :: quantity
    real(dp), intent(in) :: omega(:)                 !! rad/s
    real(dp), intent(in) :: flexibility              !! l³/EI, m/N
    complex(dp) :: factor(size(omega))
    select case (quantity)
    case ('velocity'); factor = cmplx(0.0_dp, flexibility*omega, dp)
    case ('acceleration'); factor = cmplx(-flexibility*omega**2, 0.0_dp, dp)
    case default; factor = cmplx(flexibility, 0.0_dp, dp)
    end select
  end function factors_of

  elemental subroutine keep_numbers(value)
    !! Replace values that are not finite by `missing`.
    complex(dp), intent(inout) :: value
    logical :: is_number
    is_number = ieee_is_finite(value%re) .and. ieee_is_finite(value%im)
    if (is_number) is_number = max(abs(value%re), abs(value%im)) < missing
    if (.not. is_number) value = cmplx(missing, missing, dp)
  end subroutine keep_numbers

  subroutine judge_error(answer, notes, status)
    !! Note large truncation errors. A response below its error becomes `missing`.
    type(answer_type), intent(inout) :: answer
    type(string), allocatable, intent(inout) :: notes(:)
    integer, intent(inout) :: status                 !! of the case
    real(dp), parameter :: worth_saying = 0.01_dp
    real(dp) :: largest
    integer :: p
    do p = 1, size(answer%error)
      largest = maxval(abs(answer%value(:, p)), mask=abs(answer%value(:, p)) < missing)
      if (answer%error(p) <= worth_saying*largest .or. largest <= 0.0_dp) cycle
      call append(notes, 'frequency response: the estimated error is '//shortest(answer%error(p)/largest, 2)// &
                  ' of the largest value at point '//text_of(p))
      if (answer%error(p) < largest) cycle
      answer%value(:, p) = cmplx(missing, missing, dp)
      if (allocated(answer%extremes)) answer%extremes = pack(answer%extremes, answer%extremes%point /= p)
      if (status == case_done) status = case_not_converged
    end do
  end subroutine judge_error

end module bw_case_frequency
