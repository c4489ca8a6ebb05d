module bw_stretches
  !! The stretches between blows: a blow divides one, joins two if it is dropped, or is moved, with the lines continued.
  use bw_kinds, only: dp
  use bw_line, only: bend_of, line_type
  use bw_model, only: model_type
  implicit none (type, external)
  private
  public :: add_blow, continued, drop_blow, shift_blow

  real(dp), parameter :: most_carried = 30       !! largest logarithm of an amplitude's change between samples

contains

  pure subroutine add_blow(model, b, first)
    !! Divide a stretch at a sample.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    integer :: k, i, last
    real(dp) :: m
    last = model%stretches(2, b)
    m = first - model%stretches(1, b)
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude = line%amplitude(:, [(i, i=1, b + 1), b + 1, (i, i=b + 2, size(line%amplitude, 2))])
        line%amplitude(:, b + 2) = line%amplitude(:, b + 1)*propagated(line%pole*m + bend_of(line, m))
      end associate
    end do
    call choose(model, [(i, i=0, b), b, (i, i=b + 1, ubound(model%stretches, 2))])
    model%stretches(2, b) = first - 1
    model%stretches(:, b + 1) = [first, last]
  end subroutine add_blow

  pure subroutine drop_blow(model, b)
    !! Join a stretch with the one before, whose lines continue unless it is empty.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b
    integer :: k, i, others(ubound(model%stretches, 2))
    if (model%stretches(2, b - 1) < model%stretches(1, b - 1)) then
      do k = 1, size(model%lines)
        model%lines(k)%amplitude(:, b) = model%lines(k)%amplitude(:, b + 1)
      end do
    end if
    others = [(i, i=0, b - 1), (i, i=b + 1, ubound(model%stretches, 2))]
    model%stretches(2, b - 1) = model%stretches(2, b)
    call choose(model, others)
    do k = 1, size(model%lines)
      model%lines(k)%amplitude = model%lines(k)%amplitude(:, others + 1)
    end do
  end subroutine drop_blow

  pure subroutine choose(model, others)
    !! Keep only these stretches.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: others(0:)
    integer :: stretches(2, 0:ubound(others, 1))
    stretches = model%stretches(:, others)
    deallocate (model%stretches, model%trend)
    allocate (model%stretches(2, 0:ubound(stretches, 2)), source=stretches)
    allocate (model%trend(2, size(model%white, 2), 0:ubound(stretches, 2)), source=0.0_dp)
  end subroutine choose

  pure subroutine shift_blow(model, b, first)
    !! Move a blow to a sample, and its amplitudes with it.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    real(dp) :: m
    integer :: k
    m = first - model%stretches(1, b)
    model%stretches(1, b) = first
    model%stretches(2, b - 1) = first - 1
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude(:, b + 1) = line%amplitude(:, b + 1)*propagated(line%pole*m)
      end associate
    end do
  end subroutine shift_blow

  pure function continued(model, line, b) result(amplitude)
    !! The amplitudes that the motion before blow b would have had at its first sample, (S).
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    integer, intent(in) :: b
    complex(dp) :: amplitude(size(line%amplitude, 1))
    real(dp) :: m
    amplitude = 0
    if (b < 2) return
    m = model%stretches(1, b) - model%stretches(1, b - 1)
    amplitude = line%amplitude(:, b)*propagated(line%pole*m + bend_of(line, m))
  end function continued

  elemental complex(dp) function propagated(exponent)
    !! The factor of an amplitude from one sample to another, limited in size.
    complex(dp), intent(in) :: exponent
    propagated = exp(cmplx(max(-most_carried, min(most_carried, exponent%re)), exponent%im, dp))
  end function propagated

end module bw_stretches
