module bw_mode_cluster
  !! Modes at one frequency, as far as binary128 can tell: any orthonormal motions that span them are its modes. So are modes at
  !! rest, which move the beam as a whole.
  use bw_double_double, only: dd, to_quad, operator(*)
  use bw_extended_probe, only: count_at, extended_probe, hold_root, improve, keep, start
  use bw_extended_residual, only: find_drive
  use bw_kinds, only: dp, qp
  use bw_mode_probe, only: mode_probe, set_frequency, weigh
  use bw_piece_beam, only: joint_position, piece_beam
  use bw_piece_overlap, only: mass_product, piece_modes
  implicit none (type, external)
  private
  public :: find_cluster, find_resting, keep_alone, take

  real(dp), parameter :: beside = 1.0e-15_dp       !! distance from a cluster at which its motions are found, of λ

  type, public :: mode_cluster
    integer :: first = 0, last = -1                !! numbers of the modes
    type(piece_modes) :: modes
  end type mode_cluster

contains

  pure subroutine find_resting(probe, beam, first, last, cluster)
    !! Modes of which it is known that λ = 0: the beam moves as a whole, or turns about its centre of mass or what holds it.
    type(extended_probe), intent(inout) :: probe   !! open
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: first, last             !! their numbers
    type(mode_cluster), intent(inout) :: cluster
    integer :: i, n
    call count_at(probe, dd(), n)
    call open_cluster(probe, first, last, dd(), cluster)
    associate (motion => probe%divided(probe%parts)%stiffness%motion, divided => probe%divided(probe%parts)%system%beam)
      if (moves_freely(beam)) then
        motion(1, :) = 1.0_qp
        motion(2, :) = 0.0_qp
        call keep(probe, cluster%modes, 1)
        if (first == last) return
      end if
      motion(2, :) = 1.0_qp
      do i = 0, ubound(motion, 2)
        motion(1, i) = to_quad(joint_position(divided, i)) - pivot_of(beam)
      end do
      call keep(probe, cluster%modes, last - first + 1)
    end associate
  end subroutine find_resting

  pure logical function moves_freely(beam)
    !! Nothing holds its deflection.
    type(piece_beam), intent(in) :: beam
    moves_freely = .not. (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp &
                          .or. any(beam%joint%stiffness%hi > 0.0_dp))
  end function moves_freely

  pure real(qp) function pivot_of(beam) result(pivot)
    !! Where a beam that turns freely does not move: where it is held, else its centre of mass.
    type(piece_beam), intent(in) :: beam
    real(qp) :: outer, mass
    integer :: i
    pivot = 0.0_qp
    if (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp) return
    mass = 0.0_qp
    do i = 1, size(beam%piece)
      outer = to_quad(joint_position(beam, i))
      associate (own => to_quad(beam%piece(i)%mass*beam%piece(i)%length), body => to_quad(beam%joint(i)%mass))
        pivot = pivot + own*(outer - 0.5_qp*to_quad(beam%piece(i)%length)) + body*outer
        mass = mass + own + body
      end associate
    end do
    pivot = pivot/mass
    do i = 1, size(beam%piece)
      if (beam%joint(i)%stiffness%hi > 0.0_dp) pivot = to_quad(joint_position(beam, i))
    end do
  end function pivot_of

  pure subroutine open_cluster(probe, first, last, lambda, cluster)
    !! Room for modes.
    type(extended_probe), intent(in) :: probe
    integer, intent(in) :: first, last
    type(dd), intent(in) :: lambda
    type(mode_cluster), intent(inout) :: cluster
    integer :: n, i
    cluster%first = first
    cluster%last = last
    n = size(probe%divided(1)%system%piece)
    associate (modes => cluster%modes)
      modes = piece_modes(system=probe%divided(1)%system, lambda=[(lambda, i=first, last)])
      allocate (modes%amplitude(4, n, last - first + 1), modes%deflection(n, last - first + 1), modes%turning(n, last - first + 1))
    end associate
  end subroutine open_cluster

  pure subroutine keep_alone(probe, k, lambda, cluster)
    !! The joints' motion as the one mode of a cluster.
    type(extended_probe), intent(in) :: probe
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    type(mode_cluster), intent(inout) :: cluster
    call open_cluster(probe, k, k, lambda, cluster)
    call keep(probe, cluster%modes, 1)
  end subroutine keep_alone

  subroutine find_cluster(probe, first, last, lambda, cluster)
    !! Orthonormal motions of modes at one frequency, from beside it: those before do not excite the next.
    type(extended_probe), intent(inout) :: probe   !! open
    integer, intent(in) :: first, last             !! numbers of the modes
    type(dd), intent(in) :: lambda
    type(mode_cluster), intent(inout) :: cluster
    integer, parameter :: rounds = 5
    real(qp), allocatable :: motions(:, :, :), forces(:, :, :)
    real(dp) :: correction
    integer :: i, j, n, round
    call count_at(probe, lambda*(1.0_dp + beside), n)
    call open_cluster(probe, first, last, lambda, cluster)
    associate (motion => probe%divided(probe%parts)%stiffness%motion)
      allocate (motions(2, size(motion, 2), last - first + 1), forces(2, size(motion, 2), last - first + 1))
      do i = 1, last - first + 1
        call start(probe, i)
        do round = 1, rounds
          call hold_root(probe%divided(probe%parts)%system, probe%force)
          do j = 1, i - 1
            probe%force = probe%force - forces(:, :, j)*(sum(probe%force*motions(:, :, j))/sum(forces(:, :, j)*motions(:, :, j)))
          end do
          call improve(probe, correction)
        end do
        motions(:, :, i) = motion
        forces(:, :, i) = probe%force
        call keep(probe, cluster%modes, i)
        call orthogonalize(cluster%modes, i)
      end do
    end associate
  end subroutine find_cluster

  pure subroutine orthogonalize(modes, i)
    !! Take what modes before mode i have from it; mass 1.
    type(piece_modes), intent(inout) :: modes
    integer, intent(in) :: i
    integer, parameter :: rounds = 2
    integer :: j, round
    do round = 1, rounds
      call add(modes, i, 1.0_dp/sqrt(mass_product(modes, i, modes, i)) - 1.0_dp, i)
      do j = 1, i - 1
        call add(modes, i, -mass_product(modes, i, modes, j), j)
      end do
    end do
  end subroutine orthogonalize

  pure subroutine add(modes, i, share, j)
    !! Add a share of mode j to mode i.
    type(piece_modes), intent(inout) :: modes
    integer, intent(in) :: i, j
    real(dp), intent(in) :: share
    modes%amplitude(:, :, i) = modes%amplitude(:, :, i) + share*modes%amplitude(:, :, j)
    modes%deflection(:, i) = modes%deflection(:, i) + share*modes%deflection(:, j)
    modes%turning(:, i) = modes%turning(:, i) + share*modes%turning(:, j)
  end subroutine add

  pure subroutine take(cluster, k, probe)
    !! Put a probe where mode k is.
    type(mode_cluster), intent(in) :: cluster
    integer, intent(in) :: k                       !! of the cluster
    type(mode_probe), intent(inout) :: probe
    associate (modes => cluster%modes, i => k - cluster%first + 1)
      call set_frequency(modes%system, modes%lambda(i), probe)
      probe%amplitude = modes%amplitude(:, :, i)
      probe%drive = 0.0_dp
      call weigh(modes%system, probe)            ! the root's motion
      probe%motion(1, 1:) = modes%deflection(:, i)
      probe%motion(2, 1:) = modes%turning(:, i)
      call find_drive(modes%system, probe)
      call weigh(modes%system, probe)
    end associate
  end subroutine take

end module bw_mode_cluster
