module bw_close_modes
  !! Modes that are next to each other, where binary64 shows each in the motion of the other: inverse iterations span their
  !! motions, and what these lack in double-double tells them apart (Rayleigh and Ritz). With u_i and u_j near modes at λ_i
  !! and λ_j, the lack of u_j weighed with u_i (bw_mode_probe) is ⟨u_i, (K − λ_jM)u_j⟩.
  use bw_double_double, only: dd, operator(+), operator(-)
  use bw_extended_residual, only: find_drive
  use bw_kinds, only: dp
  use bw_lapack, only: dsygv
  use bw_mode_probe, only: improve, improve_drive, left_vector, mode_probe, piece_system, probe_at, set_frequency, &
    start_bodies, weigh
  use bw_piece_overlap, only: mass_product, piece_modes
  implicit none (type, external)
  private
  public :: refine, group_for, keep, span, separate, take

  type, public :: close_modes
    integer :: first = 0, last = -1              !! numbers of the modes
    type(piece_modes) :: modes
  end type close_modes

contains

  pure subroutine refine(system, probe, lambda)
    !! λ in double-double of the mode where a probe is.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe
    type(dd), intent(inout) :: lambda
    integer :: i
    do i = 1, 2
      call set_frequency(system, lambda, probe)
      call find_drive(system, probe)
      call weigh(system, probe)
      lambda = lambda + sum(left_vector(probe)*probe%drive)/probe%mass
    end do
    call set_frequency(system, lambda, probe)
  end subroutine refine

  pure type(close_modes) function group_for(system, first, last) result(group)
    !! Room for modes by their numbers.
    type(piece_system), intent(in) :: system
    integer, intent(in) :: first, last
    group%first = first
    group%last = last
    group%modes = room_for(system, last - first + 1)
  end function group_for

  subroutine separate(group, probe)
    !! Make modes of motions that span them.
    type(close_modes), intent(inout) :: group
    type(mode_probe), intent(inout) :: probe
    integer, parameter :: rounds = 3               !! each finds shapes at frequencies that are better known
    integer :: round, k
    call tell_apart(probe, group%modes)
    do round = 1, rounds
      do k = group%first, group%last
        call take(group, k, probe)
        call improve_drive(probe)
        call iterate(group%modes%system, probe%frequency%lambda, 2, probe)
        call keep(group, k, probe)
      end do
      call tell_apart(probe, group%modes)
    end do
  end subroutine separate

  pure type(piece_modes) function room_for(system, n) result(modes)
    type(piece_system), intent(in) :: system
    integer, intent(in) :: n
    integer :: pieces
    pieces = size(system%piece)
    modes%system = system
    allocate (modes%lambda(n), modes%square(n), modes%mass(n))
    allocate (modes%amplitude(4, pieces, n), modes%deflection(pieces, n), modes%turning(pieces, n))
  end function room_for

  pure subroutine iterate(system, lambda, steps, probe)
    !! Inverse iteration at one frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda
    integer, intent(in) :: steps
    type(mode_probe), intent(inout) :: probe
    real(dp) :: correction
    integer :: i
    do i = 1, steps
      call probe_at(system, lambda, probe)
      call improve(system, probe, correction)
    end do
  end subroutine iterate

  pure subroutine keep(group, k, probe)
    !! A probe's motion, of mass 1, as that of mode k.
    type(close_modes), intent(inout) :: group
    integer, intent(in) :: k
    type(mode_probe), intent(in) :: probe
    real(dp) :: scale
    scale = 1.0_dp/sqrt(probe%mass)
    associate (i => k - group%first + 1)
      group%modes%lambda(i) = probe%frequency%lambda
      group%modes%amplitude(:, :, i) = scale*probe%amplitude
      group%modes%deflection(:, i) = scale*probe%motion(1, 1:)
      group%modes%turning(:, i) = scale*probe%motion(2, 1:)
      group%modes%mass(i) = 1.0_dp
    end associate
  end subroutine keep

  subroutine span(group, k, lambda, probe)
    !! A motion that modes before k of the group do not have, of those that are next to a frequency.
    type(close_modes), intent(inout) :: group
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    type(mode_probe), intent(inout) :: probe
    integer, parameter :: rounds = 3
    real(dp) :: share
    integer :: round, i, j
    i = k - group%first + 1
    call set_frequency(group%modes%system, lambda, probe)
    call start_bodies(k, probe)
    do round = 1, rounds
      call iterate(group%modes%system, lambda, 1, probe)
      call keep(group, k, probe)
      associate (modes => group%modes)
        do j = 1, i - 1
          share = mass_product(modes, i, modes, j)
          modes%amplitude(:, :, i) = modes%amplitude(:, :, i) - share*modes%amplitude(:, :, j)
          modes%deflection(:, i) = modes%deflection(:, i) - share*modes%deflection(:, j)
          modes%turning(:, i) = modes%turning(:, i) - share*modes%turning(:, j)
        end do
        probe%amplitude = modes%amplitude(:, :, i)
        call weigh(modes%system, probe)
        probe%motion(1, 1:) = modes%deflection(:, i)
        probe%motion(2, 1:) = modes%turning(:, i)
        probe%mass = mass_product(modes, i, modes, i)
      end associate
      call keep(group, k, probe)
      call improve_drive(probe)
    end do
  end subroutine span

  subroutine tell_apart(probe, modes)
    !! Mix motions into modes.
    type(mode_probe), intent(inout) :: probe
    type(piece_modes), intent(inout) :: modes
    real(dp), dimension(3, 2, 0:size(probe%ends), size(modes%lambda)) :: left, drive
    real(dp), dimension(size(modes%lambda), size(modes%lambda)) :: form, gram
    real(dp) :: shift(size(modes%lambda)), work(8*size(modes%lambda))
    type(dd) :: lambda, gap
    integer :: i, j, n, info
    n = size(modes%lambda)
    lambda = modes%lambda(1)
    do i = 1, n
      call put(modes, i, probe)
      modes%deflection(:, i) = probe%motion(1, 1:)
      modes%turning(:, i) = probe%motion(2, 1:)
      modes%mass(i) = probe%mass
      drive(:, :, :, i) = probe%drive
      left(:, :, :, i) = left_vector(probe)
    end do
    do j = 1, n
      gap = modes%lambda(j) - lambda
      do i = 1, n
        gram(i, j) = modes%mass(i)
        if (i /= j) gram(i, j) = mass_product(modes, i, modes, j)
        form(i, j) = gap%hi*gram(i, j) + sum(left(:, :, :, i)*drive(:, :, :, j))
      end do
    end do
    form = 0.5_dp*(form + transpose(form))
    call dsygv(1, 'V', 'U', n, form, n, gram, n, shift, work, size(work), info)
    modes%lambda = [(lambda + shift(i), i=1, n)]
    do i = 1, size(probe%ends)
      modes%amplitude(:, i, :) = matmul(modes%amplitude(:, i, :), form)
    end do
    modes%deflection = matmul(modes%deflection, form)
    modes%turning = matmul(modes%turning, form)
    modes%mass = 1.0_dp
  end subroutine tell_apart

  pure subroutine take(group, k, probe)
    !! Put a probe where mode k is.
    type(close_modes), intent(in) :: group
    integer, intent(in) :: k
    type(mode_probe), intent(inout) :: probe
    call put(group%modes, k - group%first + 1, probe)
  end subroutine take

  pure subroutine put(modes, i, probe)
    !! Put a probe where mode i is.
    type(piece_modes), intent(in) :: modes
    integer, intent(in) :: i
    type(mode_probe), intent(inout) :: probe
    call set_frequency(modes%system, modes%lambda(i), probe)
    probe%amplitude = modes%amplitude(:, :, i)
    probe%motion(1, 1:) = modes%deflection(:, i)
    probe%motion(2, 1:) = modes%turning(:, i)
    call find_drive(modes%system, probe)
    call weigh(modes%system, probe)
  end subroutine put

end module bw_close_modes
