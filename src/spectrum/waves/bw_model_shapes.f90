module bw_model_shapes
  !! The shape of a beam whose root, bodies, springs and pieces are known, at any wave number. All its conditions hold but that of
  !! the force at the tip, which an unknown mass or spring there may take up. At the wave numbers of the beam's own modes it
  !! is their shape. Lengths are in units of the beam's.
  use bw_kinds, only: dp
  use bw_lapack, only: zgbsv
  use bw_piece_beam, only: beam_joint, piece_beam
  use bw_wave_shapes, only: near, powers
  implicit none (type, external)
  private
  public :: mean_wavenumber, model_shape

  integer, parameter :: wide = 5               !! bandwidth on either side of the diagonal: conditions couple neighbouring pieces

contains

  pure real(dp) function mean_wavenumber(beam) result(mean)
    !! Mean wave number along the beam, relative to that of a uniform beam with the root's EI and the mean of ρA.
    type(piece_beam), intent(in) :: beam
    mean = sum(beam%piece%length%hi*local_factor(beam))
  end function mean_wavenumber

  pure function local_factor(beam) result(factor)
    !! Wave numbers of the pieces, relative to α.
    type(piece_beam), intent(in) :: beam
    real(dp) :: factor(size(beam%piece))
    factor = (beam%piece%mass%hi/beam%piece%stiffness%hi)**0.25_dp
  end function local_factor

  pure function model_shape(beam, alpha, position, strain) result(values)
    !! Deflections at sensors, or second derivatives over α². In each piece they are sums of cos, sin and two exponentials that
    !! decay from either end, or in short pieces of powers. Conditions are linear in the factors, so values are analytic in α.
    type(piece_beam), intent(in) :: beam           !! without shear and tension
    complex(dp), intent(in) :: alpha               !! (P l)⁴ = α⁴ where EI and ρA are 1; real part > 0
    real(dp), intent(in) :: position(:)            !! ξ, (n)
    logical, intent(in) :: strain
    complex(dp) :: values(size(position))
    complex(dp) :: conditions(3*wide + 1, 4*size(beam%piece)), factors(4*size(beam%piece), 1), here(4, 4)
    real(dp) :: ends(0:size(beam%piece)), wave(size(beam%piece))
    integer :: pivot(4*size(beam%piece)), i, n, row, info
    n = size(beam%piece)
    wave = local_factor(beam)
    ends = [0.0_dp, [(sum(beam%piece(:i)%length%hi), i=1, n)]]
    conditions = 0
    here = states(1, 0.0_dp)
    if (beam%root%holds_deflection) then
      call put(conditions, 1, here(1, :), 1)
    else
      call put(conditions, 1, here(4, :) + beam%root%stiffness%hi*here(1, :), 1)
    end if
    if (beam%root%holds_turning) then
      call put(conditions, 2, here(2, :), 1)
    else
      call put(conditions, 2, here(3, :) - beam%root%turning_stiffness%hi*here(2, :), 1)
    end if
    do i = 1, n
      here = states(i, beam%piece(i)%length%hi)
      here(3, :) = here(3, :) + moment_of(beam%joint(i))*here(2, :)
      if (i == n) exit
      here(4, :) = here(4, :) + force_of(beam%joint(i))*here(1, :)
      associate (next => states(i + 1, 0.0_dp))
        do row = 1, 4
          call put(conditions, 4*i - 2 + row, [here(row, :), -next(row, :)], 4*i - 3)
        end do
      end associate
    end do
    factors = 0
    factors(4*n, 1) = 1
    call put(conditions, 4*n - 1, here(3, :), 4*n - 3)
    call put(conditions, 4*n, here(1, :) - here(4, :)/(beam%piece(n)%stiffness%hi*(alpha*wave(n))**3), 4*n - 3)   ! never 0
    call zgbsv(4*n, wide, wide, 1, conditions, size(conditions, 1), pivot, factors, 4*n, info)
    if (info > 0) factors = 0                        ! singular: no shape
    do row = 1, size(position)
      i = max(1, count(ends(:n - 1) < position(row)))
      here = states(i, min(position(row), ends(i)) - ends(i - 1))
      if (strain) here(1, :) = here(3, :)/(beam%piece(i)%stiffness%hi*alpha**2)
      values(row) = sum(here(1, :)*factors(4*i - 3:4*i, 1))
    end do

  contains

    pure subroutine put(band, row, condition, first)
      !! Add a condition on the factors from `first` on. All but the last sum to 0; the sum of the last only scales the shape.
      complex(dp), intent(inout) :: band(:, :)     !! in LAPACK's band storage
      integer, intent(in) :: row, first
      complex(dp), intent(in) :: condition(:)
      integer :: j
      do j = 1, size(condition)
        band(2*wide + 2 + row - first - j, first + j - 1) = condition(j)/maxval(abs(condition))
      end do
    end subroutine put

    pure function states(piece, place) result(state)
      !! Deflection, slope, bending moment and shear force EI v''' of the four functions of a piece.
      integer, intent(in) :: piece
      real(dp), intent(in) :: place                !! from its inner end
      complex(dp) :: state(4, 4), power(4), a
      integer :: order, m
      a = alpha*wave(piece)
      associate (length => beam%piece(piece)%length%hi)
        if (real(a)*length < near) then            ! the four functions would be nearly dependent
          power = [(powers(a*place, m), m=0, 3)]   ! each is the derivative of the next
          do m = 0, 3
            state(:, m + 1) = [(a**order*power(1 + modulo(m - order, 4)), order=0, 3)]/(a*length)**m
          end do
        else
          state(1, :) = [cos(a*place), sin(a*place), exp(-a*place), exp(-a*(length - place))]
          state(2, :) = a*[-state(1, 2), state(1, 1), -state(1, 3), state(1, 4)]
          do order = 3, 4
            state(order, :) = a**2*[-1, -1, 1, 1]*state(order - 2, :)
          end do
        end if
      end associate
      state(3:4, :) = beam%piece(piece)%stiffness%hi*state(3:4, :)
    end function states

    pure complex(dp) function force_of(joint)
      !! Shear force beyond a joint minus that before it, divided by the deflection.
      type(beam_joint), intent(in) :: joint
      force_of = joint%mass%hi*alpha**4 - joint%stiffness%hi
    end function force_of

    pure complex(dp) function moment_of(joint)
      !! Moment beyond a joint minus that before it, divided by the slope; sections turn in the rotating frame.
      type(beam_joint), intent(in) :: joint
      moment_of = joint%turning_stiffness%hi - joint%inertia%hi*(alpha**4 &
        & - merge(beam%spin_squared%hi, 0.0_dp, beam%in_plane))
    end function moment_of

  end function model_shape

end module bw_model_shapes
